"""The public call `check`, and the class of its result."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..crosscheck import Result, SceneError, Source
from ..crosscheck.problem.written import shown
from ..crosscheck.result.words import Account
from ..crosscheck.scene.calls import naming_arguments
from ..crosscheck.scene.keys import numbers
from . import checked

if TYPE_CHECKING:
    from ..figures.style import Picture
    from .tables import OthersResults


class Checked(Result, checked.CheckedOutcome):
    """A run together with results of other programs, which are compared with it.

    `verdicts`, `diagnoses` and `passes` describe these results. The texts and figures are about
    these results first, and then about our own methods.
    """

    def _catalogue(self) -> "Sequence[Picture]":
        """Return the figures that a check may have, those of the checked results first."""
        from .pictures import CHECK_PICTURES

        return sorted(CHECK_PICTURES, key=lambda picture: not self.shows_others(picture))

    @property
    def _account(self) -> Account:
        """All texts about the results of other programs, and about ours."""
        from .account import CheckAccount

        return CheckAccount(self)


@naming_arguments
def check(
    scene: Source,
    given: "Mapping[str, OthersResults] | OthersResults",
    methods: Sequence[str] | str | None = None,
    within: float = 0.01,
    columns: Mapping[str, str] | None = None,
    units: str = "",
    sizes: Sequence[float] = (),
    memory: float | None = None,
) -> Checked:
    """Compare results of other programs with ours, at their times and radii.

    Parameters
    ----------
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries
    given : results of other programs: CSV or netCDF files, DataFrames or xarray Datasets, by the
        names of the programs; or a single one, which is named after its file, or "theirs"
    methods : methods of ringwear, instead of the scene's
    within : allowed relative error of their results
    columns : our names by theirs, ``{"p": "pressure"}``
    units : of their results, such as ``"mm, N, MPa, s"``, if they differ from the scene's
    sizes : decreasing element sizes, if the results are those of one program from coarse to fine
    memory : largest memory to use, in GiB; by default that of the machine

    Raises
    ------
    SceneError
        if a table cannot be read; the message names the file, the line, the column and the remedy.
        If there are so many times and radii that memory does not suffice, it says how many fit

    Examples
    --------
    >>> from pandas import DataFrame
    >>> table = DataFrame({"time": [0.0], "indentation": [0.97]})
    >>> checked = check("flat_punch", {"abaqus": table}, methods=["mdr"])
    >>> round(checked.verdicts[0].error, 4), checked.passes
    (-0.03, False)
    """
    from .check import check_as

    if not (isinstance(within, float | int) and within > 0):
        raise SceneError(f"within = {shown(within)}: give a positive number, such as 0.01")
    programs, sizes = _by_program(given), numbers("sizes", sizes)
    return check_as(Checked, scene, programs, methods, within, columns, units, sizes, memory)


def _by_program(given: "Mapping[str, OthersResults] | OthersResults") -> "dict[str, OthersResults]":
    """Return results of other programs by the names of the programs."""
    kinds = (str, Path)
    # a Dataset is a mapping, too, but it has `to_dataframe`
    if isinstance(given, Mapping) and not hasattr(given, "to_dataframe"):
        if any(
            isinstance(value, kinds) or hasattr(value, "columns") for value in given.values()
        ) or any(hasattr(value, "data_vars") for value in given.values()):
            return dict(given)
        if given:  # the columns of one table
            from pandas import DataFrame

            try:
                return {"theirs": DataFrame(given)}
            except ValueError:
                raise SceneError(
                    f"{shown(given)} is no table: give a file, a DataFrame, a Dataset, or these by "
                    "the names of their programs"
                ) from None
    if isinstance(given, kinds):
        return {Path(given).name: given}
    if hasattr(given, "columns") or hasattr(given, "data_vars"):
        return {"theirs": given}
    raise SceneError(
        f"no results of other programs in {shown(given)}: give files, DataFrames or Datasets by "
        "the names of the programs, {'abaqus': 'abaqus.csv'}, or a single one"
    )
