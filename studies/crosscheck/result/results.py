"""The public calls `run` and `load`, and the class of their result."""

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from ....meshes.errors import RingwearError, SceneError
from ..methods.base import Method
from ..problem.quantities import DESCRIBED, SYMBOLS
from ..problem.written import shown
from ..registry import METHODS
from ..scene.calls import naming_arguments
from ..scene.explain import nearest
from ..scene.keys import listed
from ..scene.scene import Scene, Source
from .guesses import OF_RESULTS, missing_attribute
from .outcome import Outcome
from .output import stored
from .output.files import run_files, write_numbers
from .output.folder import output_folder
from .predictions.memory import refuse_beyond_memory
from .run import run_as
from .scope import methods_of, refuse
from .words import Account

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from xarray import DataArray

    from ...figures.style import Picture


@naming_arguments
def run(
    scene: Source,
    methods: Sequence[str | Method] | str | None = None,
    rtol: float | None = None,
    quantities: Sequence[str] | str | None = None,
    memory: float | None = None,
) -> "Result":
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Every method solves the same problem: a rigid punch of concentric rings on an elastic
    half-space that wears by Archard's law ``df/dt = k p v``. Each method estimates its own errors,
    so that two methods can be compared.

    Parameters
    ----------
    scene : Scene, str, Path or dict
        Punch, half-space, load, times and the relative tolerance ``rtol``: a Scene, the name of a
        bundled scene, a file, or nested dictionaries. Its numbers are in any consistent units.
    methods : sequence of str or Method, optional
        Names of methods, or your own Method objects, instead of the scene's methods. Results and
        figures are in this order. If neither gives any, those of 'mdr', 'direct' and 'fem' that can
        solve the scene; ``summary["left_out"]`` names the others, with the reasons.

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
          axisymmetric pressure, so that only the pressures and, for shaped punches, the time steps
          are discretised.
        * 'bem' (boundary elements): the same pressures with the ring kernel of Eq. 19. It uses no
          identity of the MDR; choose it to check 'mdr' at the same cost.
        * 'fem' (finite elements): a meshed half-space with Boussinesq's far field. It shares
          neither a kernel nor a mesh with the others, and is the only method with displacements
          and stresses inside the half-space. Choose it as the independent check, or to test a mesh.
          On triangles its energies converge with order 2k in the element size, for displacements of
          degree k.
        * 'direct' (direct integration, Eqs. 21 to 27): the steady state to roundoff. Choose it if
          no history is needed, especially in sweeps. It refuses a wear coefficient that varies
          along the radius, and a fixed indentation, under which the pressure decays to zero.
        * 'mdr-grid' (the algorithm of the paper): springs on a uniform grid and explicit steps, of
          first order in both; the indentation of five rings with 400 springs has the relative error
          1.8e-3. Choose it to reproduce the paper. It also refuses hollow punches, loads that vary,
          and scenes without times.

        "Exponentially" refers to the number of unknowns, for contact whose edges do not move. While
        edges move, pressures are linear on cells, and time steps are of second order. The seconds
        are those of solving `five_rings` at ``rtol = 1e-4`` on one core, including the error
        estimate, as in `summary.json`.

    rtol : float, optional
        Relative tolerance, instead of the scene's.
    quantities : sequence of str, optional
        Names of quantities, or of groups of them, instead of the scene's.
    memory : float, optional
        Largest memory to use, in GiB; by default that of the machine. A run that is predicted to
        need more is refused.

    Returns
    -------
    Result
        With the following attributes, among others:

        dataset : xarray.Dataset
            Quantities by solver, time, radius, ring and mode, in the scene's units; the relative
            error estimate of each is in ``<quantity>_error``. NaN if a method does not compute it.
        answers : dict
            The numbers of the answer, by method.
        verdict : str
            "agree", "disagree" or "undecided".
        agreement : tuple of Agreement
            The verdict on each quantity and pair of methods.
        anchors : tuple of Anchor
            Comparisons of reported numbers with closed forms and conservation laws.
        operators : tuple of OperatorDifference
            Comparisons of methods for every pressure at once.
        warnings : tuple of str
            What to know before the numbers are used, such as that linear elasticity is not valid.
        summary : dict
            All of these except the fields, and the seconds, sizes and notes of each method.

    Raises
    ------
    SceneError
        If a method cannot solve the scene, or if memory does not suffice; the message names the key
        and the remedy. This is raised before anything is computed.
    MeshError
        If a mesh of the half-space cannot be generated.
    SolverError
        If a linear system has no meaningful solution.

    Notes
    -----
    **Accuracy.** ``rtol`` bounds the relative error of every quantity in the norm of the quantity.
    If a method's error estimates are larger, it solves again with finer sizes, unless the scene
    gives the sizes. `Result.left_out_of_promise` lists the quantities and times for which this
    accuracy is not promised, with the reasons.

    **Verdict.** Two methods *agree* on a quantity if, at every time, both error estimates are at
    most ``rtol`` (twice that while edges of the contact move) and the difference is at most twice
    this bound. They *disagree* if the difference is larger than that and larger than the sum of
    both error estimates. All other cases are *undecided*. The verdict on the run is the worst one
    on the promised quantities. It is "disagree" if an anchor does not hold, and "undecided" if an
    anchor is missing or if there is only one method. A larger error estimate never turns a verdict
    into "agree".

    Progress is logged by the logger `ringwear`.

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
    entries = listed(() if methods is None else methods)
    if invalid := [entry for entry in entries if not isinstance(entry, str | Method)]:
        raise SceneError(
            f"methods has {shown(invalid[0])}: give names, {', '.join(METHODS)}, or objects of a "
            "Method"
        )
    named = all(isinstance(entry, str) for entry in entries)
    names = [str(entry) for entry in entries] if named and methods is not None else None
    scene = Scene.of(scene, names, rtol, quantities)
    by_name = methods_of(entries or scene.methods)
    refuse(scene, by_name)
    refuse_beyond_memory(scene, by_name.values(), memory)
    return run_as(Result, scene, entries or None)


class Result(Outcome):
    """All results of a run.

    `dataset` (xarray, in the scene's units), `answers` by method, `verdict`, `error(name)`,
    `warnings`, `remarks`, `agreement`, `anchors`, `summary`, `plots`, `plot(kind)` and
    `save(folder)`.
    """

    def __repr__(self) -> str:
        """Return the answer in a few lines, the verdict, and warnings."""
        return "\n".join(self._account.brief)

    def _repr_html_(self) -> str:
        """Return the answer, the verdict and one figure as HTML, for notebooks."""
        text = f"<pre>{escape(repr(self))}</pre>"
        if not self._pictures:
            return text
        from ...figures.style import html_of

        return text + html_of(self.plot())

    @property
    def _pictures(self) -> "dict[str, Picture]":
        """The figures that can be drawn from the results, by their names."""
        drawn = (picture for picture in self._catalogue() if picture.drawn_for(self))
        return {Path(picture.file).stem: picture for picture in drawn}

    def _catalogue(self) -> "Sequence[Picture]":
        """Return the figures that such results may have."""
        from ...figures.catalogue import PICTURES

        return PICTURES

    @property
    def plots(self) -> tuple[str, ...]:
        """The figures that `plot` can draw of these results."""
        return tuple(self._pictures)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the command prints below the verdict.

        These are warnings, anchors that do not hold, disagreements, and what is undecided, with
        reasons and remedies; errors above `rtol`; and notes.
        """
        return tuple(self._account.remarks)

    @property
    def _account(self) -> Account:
        """All texts about the results."""
        return Account(self)

    def __getitem__(self, quantity: str) -> "DataArray":
        """Return a quantity or a coordinate of `dataset`.

        Raises
        ------
        SceneError
            if there is none of that name; the message suggests the nearest name
        """
        if quantity not in self.dataset.variables:
            names = [str(name) for name in self.dataset.variables]
            suggestion = _quantity_like(str(quantity), names)
            hint = f"did you mean {suggestion!r}? Else " if suggestion else ""
            if quantity in METHODS:
                hint = f"write result.dataset.sel(solver={quantity!r}), or "
            raise SceneError(
                f"no {shown(quantity)} in these results: {hint}give one of {', '.join(names)}"
            )
        return self.dataset[quantity]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Raise an AttributeError that says what to write instead."""
            return missing_attribute(self, name, f"a result has no {name!r}{_instead_of(name)}")

    def plot(self, kind: str = "") -> "Figure":
        """Draw a figure.

        Parameters
        ----------
        kind : ``"profiles_and_pressures"``, ``"history"``, ``"contact"``, ``"steady_state"``,
            ``"difference"``, ``"operator_difference"``, ``"stress"`` or ``"mesh"``; by default
            the first of these that can be drawn

        Raises
        ------
        SceneError
            if the results have no such figure; the message lists the available ones
        """
        pictures = self._pictures
        kind = kind or next(iter(pictures), "")
        if not isinstance(kind, str) or kind not in pictures:
            available = ", ".join(pictures) or "none: all selected quantities are numbers"
            suggestion = nearest(str(kind), pictures)
            hint = f"did you mean {suggestion!r}? Else " if suggestion else ""
            raise SceneError(
                f"no figure {shown(kind)} of these results: {hint}give one of {available}"
            )
        return pictures[kind].figure(self)

    def save(self, folder: str | Path) -> list[str]:
        """Write the files of ``ringwear run --out folder``; return their names.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or contains other files with these names
        RingwearError
            if a figure cannot be drawn
        """
        from ...report.page import show

        pictures = self._catalogue()
        with output_folder(folder, "run", run_files(pictures)) as out:
            write_numbers(self, out.hidden)
            if failures := show(self, self._account, pictures, out.hidden, page=True):
                raise RingwearError("; ".join(failures))
        return out.written


class Stored(Result, stored.StoredOutcome):
    """Results from a folder: all numbers, and the figures that need only these."""

    def __repr__(self) -> str:
        """Return the answer in a few lines, the verdict, and remarks on the files."""
        return "\n".join([super().__repr__(), *self.remarks_on_files])


def load(folder: str | Path) -> Stored:
    """Read the results that ``ringwear run --out folder``, or `Result.save`, has written.

    Both files are compared with the checksums in `summary.json`. Results that were saved without
    checksums are read, too, with the remark that they could not be checked.

    Raises
    ------
    SceneError
        if the folder contains no results that can be read, or if they do not match their
        checksums; the message names what does not match
    """
    return stored.load(folder, Stored)


def _quantity_like(name: str, names: Iterable[str]) -> str:
    """Return which of our names is meant by another name; empty if none is similar."""
    return nearest(SYMBOLS.get(name, name), names)


def _instead_of(name: str) -> str:
    """Return what to write instead of an attribute that a result does not have."""
    if replacement := OF_RESULTS.get(name):
        return f": write result.{replacement}"
    public = [attribute for attribute in dir(Result) if not attribute.startswith("_")]
    if suggestion := nearest(name, public, 0.8):
        return f": did you mean result.{suggestion}?"
    if suggestion := _quantity_like(name, [*DESCRIBED, "time", "radius", "solver"]):
        return f": write result.dataset.{suggestion}"
    return f"; it has {', '.join(public)}"
