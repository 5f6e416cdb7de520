"""What a script works with: runs of scenes, and results that show, save and load themselves."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import fields
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ..meshes.errors import RingwearError, SceneError
from .check import checked
from .crosscheck import dataset
from .crosscheck.run import run as compute
from .methods.base import Method
from .output import stored
from .output.files import run_files, write_numbers
from .output.folder import output_folder
from .problem.scene import Scene, Source, listed
from .report.words import Account

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .check.tables import OthersResults
    from .figures.style import Picture

Shown = TypeVar("Shown", bound="Result")


def run(
    scene: Source,
    methods: Sequence[str | Method] | str | None = None,
    rtol: float | None = None,
    quantities: Sequence[str] | str | None = None,
) -> "Result":
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Progress goes to the logger `ringwear`.

    Parameters
    ----------
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries
    methods : names of methods, and methods of one's own, in place of the scene's; the docstring of
        `ringwear.studies.crosscheck.run.run` says what each gives, for which punches, and when to
        choose it
    rtol : relative accuracy wanted, in place of the scene's
    quantities : names of those wanted, or groups of them, in place of the scene's

    Raises
    ------
    SceneError
        if the scene is none, or a method cannot solve it; the message names the remedy
    RingwearError
        if a mesh or a system fails

    Examples
    --------
    >>> result = run("five_rings", methods=["mdr", "direct"], rtol=1e-3)
    >>> result.verdict
    'agree'
    >>> depth = result.dataset.indentation.sel(solver="mdr", time=0.0)
    >>> float(abs(depth - 1.0)) <= result.error("indentation")  # F / (2 a E*)
    True
    """
    entries = listed(methods or ())
    named = all(isinstance(entry, str) for entry in entries)
    names = [str(entry) for entry in entries] if named and methods is not None else None
    return _as(Result, compute(Scene.of(scene, names, rtol, quantities), entries or None))


class Result(dataset.Result):
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
        image = BytesIO()
        self.plot().savefig(image, dpi=100)
        picture = b64encode(image.getvalue()).decode()
        return f'{told}<img src="data:image/png;base64,{picture}">'

    @property
    def _pictures(self) -> "dict[str, Picture]":
        """The figures that the results have, by their names."""
        from .figures.catalogue import PICTURES

        return {Path(of.file).stem: of for of in PICTURES if of.drawn_for(self)}

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
        if kind not in drawn:
            there = ", ".join(drawn) or "none: all quantities asked for are numbers"
            raise SceneError(f"no figure {kind!r} of these results: give one of {there}")
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


class Stored(Result, stored.Stored):
    """Results that were written: all numbers, and the figures that need no more."""


def load(folder: str | Path) -> Stored:
    """Read the results that ``ringwear run --out folder``, or `Result.save`, has written.

    Raises
    ------
    SceneError
        if the folder holds none that can be read
    """
    return _as(Stored, stored.load(folder))


class Checked(Result, checked.Checked):
    """A run beside which results of other programs stand.

    `verdicts`, `diagnoses` and `passes` tell about these results.
    """


def check(scene: Source, given: "Mapping[str, OthersResults]", **how: Any) -> Checked:
    """Hold results of other programs against ours, at their times and radii.

    Parameters
    ----------
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries
    given : CSV or netCDF files, DataFrames or xarray Datasets, by the names of their programs
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
    from .check.check import check as hold_against

    return _as(Checked, hold_against(scene, given, **how))


def _as(kind: type[Shown], result: dataset.Result) -> Shown:
    """Return results that show themselves."""
    return kind(*(getattr(result, field.name) for field in fields(result)))
