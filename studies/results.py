"""What a script works with: runs of scenes, and results that show, save and load themselves."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..meshes.errors import RingwearError, SceneError
from .calls import naming_arguments
from .check import checked
from .methods.base import Method
from .outcome.outcome import Outcome
from .outcome.run import run_as
from .output import stored
from .output.files import run_files, write_numbers
from .output.folder import output_folder
from .problem.quantities import DESCRIBED
from .registry import METHODS
from .report.words import Account
from .scene.explain import nearest, shown
from .scene.keys import listed
from .scene.scene import Scene, Source

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from xarray import DataArray

    from .check.tables import OthersResults
    from .figures.style import Picture


@naming_arguments
def run(
    scene: Source,
    methods: Sequence[str | Method] | str | None = None,
    rtol: float | None = None,
    quantities: Sequence[str] | str | None = None,
) -> "Result":
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Every method solves the same problem: a rigid punch of concentric rings on an elastic
    half-space, which wears by Archard's law ``df/dt = k p v``. Each estimates its own errors, so
    that two methods can be compared.

    Parameters
    ----------
    scene : Scene, str, Path or dict
        What is computed: punch, half-space, load, times, and the relative accuracy ``rtol``. A
        Scene, the name of a bundled one, a file, or nested dictionaries; its numbers are in any
        consistent units.
    methods : sequence of str or Method, optional
        Methods in place of the scene's, by their names, or as objects of one's own. Their order is
        that of results and figures.

        ========  ========================  ========================  ==================  =======
        name      gives                     punches                   error falls         seconds
        ========  ========================  ========================  ==================  =======
        mdr       start, history, steady    all                       exponentially       0.13
        bem       start, history, steady    all                       exponentially       0.10
        fem       the same, and the inside  all                       exponentially       0.48
        direct    steady                    k constant on rings       closed form         0.002
        mdr-grid  start, history            flat discs, as `direct`   as step and cell    0.55
        ========  ========================  ========================  ==================  =======

        * 'mdr' (dimensionality reduction): the default choice. Its energy is exact for every
          axisymmetric pressure, so that only the pressures and, for shaped punches, the steps are
          discretised.
        * 'bem' (boundary elements): the same pressures by the ring kernel of Eq. 19. It uses no
          identity of the MDR: choose it to check 'mdr' at the same cost.
        * 'fem' (finite elements): a meshed half-space with Boussinesq's far field. It shares
          neither a kernel nor a mesh with the others, and alone gives displacements and stresses
          inside. Choose it as the independent check, or to test a mesh. On triangles its energies
          are of order 2k in the element size, for displacements of degree k.
        * 'direct' (direct integration, Eqs. 21 to 27): the steady state to roundoff. Choose it
          where no history is wanted, in sweeps above all. It refuses a wear coefficient that varies
          along the radius, and a fixed indentation, under which nothing presses in the end.
        * 'mdr-grid' (the algorithm of the paper): springs on a uniform grid and explicit steps, of
          first order in both; five rings by 400 springs err by 1.8e-3 in the indentation. Choose it
          to reproduce the paper. It also refuses hollow punches, loads that vary, and scenes
          without times.

        "Exponentially" is with the number of unknowns, for contact whose edges do not move. While
        edges move, pressures are linear on cells, and steps in time are of second order. Seconds
        are those of solving `five_rings` at ``rtol = 1e-4`` on one core, with the error estimate,
        as `summary.json` lists them.

    rtol : float, optional
        Relative accuracy wanted, in place of the scene's.
    quantities : sequence of str, optional
        Names of quantities wanted, or groups of them, in place of the scene's.

    Returns
    -------
    Result
        With the following attributes, among others:

        dataset : xarray.Dataset
            Quantities by solver, time, radius, ring and mode, in the scene's units; the relative
            error estimate of each is in ``<quantity>_error``. NaN where a method does not give it.
        answers : dict
            The numbers of the answer, by method.
        verdict : str
            "agree", "disagree" or "undecided".
        agreement : tuple of Agreement
            A row for each quantity and pair of methods.
        anchors : tuple of Anchor
            Comparisons of reported numbers with closed forms and conservation laws.
        operators : tuple of OperatorDifference
            Comparisons of methods for every pressure at once.
        summary : dict
            All of that but the fields, and the seconds, sizes and notes of each method.

    Raises
    ------
    SceneError
        If a method cannot solve the scene; the message names the key and the remedy. Nothing is
        computed then.
    MeshError
        If a mesh of the half-space cannot be made.
    SolverError
        If a system has no meaningful solution.

    Notes
    -----
    **Accuracy.** ``rtol`` bounds the relative error of every quantity, each in a norm of its own.
    A method whose own estimates fall short of it solves again with finer sizes, unless the scene
    gives the sizes. `Result.left_out_of_promise` lists what cannot be promised, and why.

    **Verdict.** Two methods *agree* on a quantity if, at every time, each states an error of at
    most ``rtol`` (twice that while edges of the contact move) and they differ by at most twice
    what each may state. They *disagree* if they differ by more than that and by more than the sum
    of their error estimates. All else is *undecided*. The verdict on the run is the least of all
    that is promised. It is "disagree" if an anchor does not hold, and "undecided" if an anchor is
    missing or if there is one method only. A larger error estimate never turns a verdict into
    "agree".

    Progress goes to the logger `ringwear`.

    Examples
    --------
    Five rings under the force 2, with the radius 1 and the plane strain modulus 1, start at
    ``d = F / (2 a E*) = 1``:

    >>> result = run("five_rings", methods=["mdr", "direct"])
    >>> start = result.dataset.indentation.sel(solver="mdr", time=0.0)
    >>> bool(abs(start - 1.0) < 1e-4)
    True

    Both methods give the steady state, in which all rings wear at one rate:

    >>> rates = result.dataset.steady_wear_rate
    >>> bool(abs(rates.sel(solver="mdr") / rates.sel(solver="direct") - 1) < 1e-4)
    True
    >>> result.verdict
    'agree'
    """
    entries = listed(methods or ())
    if strange := [entry for entry in entries if not isinstance(entry, str | Method)]:
        raise SceneError(
            f"methods has {strange[0]!r}: give names, {', '.join(METHODS)}, or objects of a Method"
        )
    named = all(isinstance(entry, str) for entry in entries)
    names = [str(entry) for entry in entries] if named and methods is not None else None
    return run_as(Result, Scene.of(scene, names, rtol, quantities), entries or None)


class Result(Outcome):
    """Everything that a run computed.

    `dataset` (xarray, in the scene's units), `answers` by method, `verdict`, `error(name)`,
    `agreement`, `anchors`, `summary`, `plot(kind)` and `save(folder)`.
    """

    def __repr__(self) -> str:
        """Return the answer in a few lines, and the verdict."""
        return "\n".join(Account(self).brief)

    def _repr_html_(self) -> str:
        """Return the answer, the verdict and one figure as HTML, for notebooks."""
        told = f"<pre>{escape(repr(self))}</pre>"
        if not self._pictures:
            return told
        from .figures.style import html_of

        return told + html_of(self.plot())

    @property
    def _pictures(self) -> "dict[str, Picture]":
        """The figures that the results have, by their names."""
        from .figures.catalogue import PICTURES

        return {Path(of.file).stem: of for of in PICTURES if of.drawn_for(self)}

    def __getitem__(self, quantity: str) -> "DataArray":
        """Return a quantity or a coordinate of `dataset`.

        Raises
        ------
        SceneError
            if it has none of that name, naming the nearest
        """
        if quantity not in self.dataset.variables:
            names = [str(name) for name in self.dataset.variables]
            near = _quantity_like(str(quantity), names)
            meant = f"did you mean {near!r}? Else " if near else ""
            raise SceneError(
                f"no {quantity!r} in these results: {meant}give one of {', '.join(names)}"
            )
        return self.dataset[quantity]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Tell what to write in place of what a result does not have."""
            if not name.startswith("_") and hasattr(type(self), name):  # a property that has failed
                return object.__getattribute__(self, name)
            raise AttributeError(f"a result has no {name!r}{_instead_of(name)}")

    def plot(self, kind: str = "") -> "Figure":
        """Draw a figure.

        Parameters
        ----------
        kind : ``"profiles_and_pressures"``, ``"history"``, ``"contact"``, ``"steady_state"``,
            ``"difference"``, ``"operator_difference"``, ``"stress"`` or ``"mesh"``; by default
            the first of them that the results have

        Raises
        ------
        SceneError
            if the results have no such figure, naming those that they have
        """
        drawn = self._pictures
        kind = kind or next(iter(drawn), "")
        if not isinstance(kind, str) or kind not in drawn:
            there = ", ".join(drawn) or "none: all quantities asked for are numbers"
            near = nearest(str(kind), drawn)
            meant = f"did you mean {near!r}? Else " if near else ""
            raise SceneError(f"no figure {kind!r} of these results: {meant}give one of {there}")
        return drawn[kind].figure(self)

    def save(self, folder: str | Path) -> list[str]:
        """Write what ``ringwear run --out folder`` does; return the names of the files.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or holds files of others with these names
        RingwearError
            if a figure cannot be drawn
        """
        from .figures.catalogue import PICTURES
        from .report.page import show

        with output_folder(Path(folder), "run", run_files(PICTURES)) as out:
            write_numbers(self, out.hidden)
            if failures := show(self, Account(self), PICTURES, out.hidden, page=True):
                raise RingwearError("; ".join(failures))
        return out.written


class Stored(Result, stored.StoredOutcome):
    """Results that were written: all numbers, and the figures that need no more."""


def load(folder: str | Path) -> Stored:
    """Read the results that ``ringwear run --out folder``, or `Result.save`, has written.

    Raises
    ------
    SceneError
        if the folder holds none that can be read
    """
    return stored.load(folder, Stored)


class Checked(Result, checked.CheckedOutcome):
    """A run beside which results of other programs stand.

    `verdicts`, `diagnoses` and `passes` tell about these results.
    """


@naming_arguments
def check(
    scene: Source, given: "Mapping[str, OthersResults] | OthersResults", **how: Any
) -> Checked:
    """Hold results of other programs against ours, at their times and radii.

    Parameters
    ----------
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries
    given : CSV or netCDF files, DataFrames or xarray Datasets, by the names of their programs; or
        one alone, which is called "theirs", or by the name of its file
    how : `methods` of ours, in place of the scene's; `within`, the relative error that theirs are
        allowed, 0.01; `columns`, names of ours by theirs, ``{"p": "pressure"}``; `units` of theirs,
        such as ``"mm, N, MPa, s"``, if not the scene's; `sizes`, decreasing, if they are of one
        program from coarse to fine

    Raises
    ------
    SceneError
        if a table cannot be read, naming the file, the line, the column and the remedy

    Examples
    --------
    >>> from pandas import DataFrame
    >>> table = DataFrame({"time": [0.0], "indentation": [0.97]})
    >>> checked = check("flat_punch", {"abaqus": table}, methods=["mdr"])
    >>> round(checked.verdicts[0].error, 4), checked.passes
    (-0.03, False)
    """
    from .check.check import check_as

    if "within" in how and not (isinstance(how["within"], float | int) and how["within"] > 0):
        raise SceneError(f"within = {how['within']!r}: give a positive number, such as 0.01")
    return check_as(Checked, scene, _by_program(given), **how)


def _by_program(given: "Mapping[str, OthersResults] | OthersResults") -> "dict[str, OthersResults]":
    """Return results of others by the names of their programs."""
    kinds = (str, Path)
    # a dataset is a mapping, too, of its variables
    if isinstance(given, Mapping) and not hasattr(given, "to_dataframe"):
        if any(isinstance(of, kinds) or hasattr(of, "columns") for of in given.values()) or any(
            hasattr(of, "data_vars") for of in given.values()
        ):
            return dict(given)
        if given:  # columns
            from pandas import DataFrame

            return {"theirs": DataFrame(given)}
    if isinstance(given, kinds):
        return {Path(given).name: given}
    if hasattr(given, "columns") or hasattr(given, "data_vars"):
        return {"theirs": given}
    raise SceneError(
        f"no results of others in {shown(given)}: give files, DataFrames or Datasets by the names "
        "of their programs, {'abaqus': 'abaqus.csv'}, or one alone"
    )


def _quantity_like(name: str, names: Iterable[str]) -> str:
    """Return the one of our names that somebody else's stands for; empty if it is like none."""
    from .check.csv_files import SYMBOLS

    return nearest(SYMBOLS.get(name, name), names)


def _instead_of(name: str) -> str:
    """Return what to write in place of what a result does not have."""
    if other := OTHER_CALLS.get(name):
        return f": write result.{other}"
    public = [known for known in dir(Result) if not known.startswith("_")]
    if near := nearest(name, public, 0.8):
        return f": did you mean result.{near}?"
    if near := _quantity_like(name, [*DESCRIBED, "time", "radius", "solver"]):
        return f": write result.dataset.{near}"
    return f"; it has {', '.join(public)}"


# what to write in place of calls that other packages have
OTHER_CALLS = {
    "times": "dataset.time",
    "radii": "dataset.radius",
    "errors": "error('indentation')",
    "show": "plot()",
    "data": "dataset",
    "ds": "dataset",
    **{name: f"dataset.{name}" for name in ("sel", "isel", "interp", "to_dataframe", "to_netcdf")},
}
