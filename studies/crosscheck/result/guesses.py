"""Answer guessed attributes of results with a line that says what to write instead."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, NoReturn

from ..problem.suggestions import nearest
from ..problem.written import shown
from ..registry import METHODS

# what to write instead of attributes of results that other packages have
OF_RESULTS = {
    "times": "dataset.time",
    "radii": "dataset.radius",
    "errors": "error('indentation')",
    "show": "plot()",
    "figures": "plot('history'), or result.save(folder)",
    "figure": "plot()",
    "mesh": "plot('mesh'), or result.save(folder)",
    "stress": "plot('stress'), or result.save(folder)",
    "half_space": "scene.half_space",
    "units": "scene.units",
    "seconds": "summary['seconds']",
    "error_estimate": "error('indentation')",
    "report": "save(folder), which writes report.html",
    **dict.fromkeys(("to_csv", "write", "export", "to_file"), "save(folder)"),
    **dict.fromkeys(("data", "ds", "df", "results", "to_xarray"), "dataset"),
    **dict.fromkeys(("to_pandas", "to_dict"), "dataset.to_dataframe()"),
    **dict.fromkeys(("keys", "values", "items"), "dataset.variables"),
    **{name: f"dataset.sel(solver={name!r})" for name in METHODS},
    **{name: f"dataset.{name}" for name in ("sel", "isel", "interp", "to_dataframe", "to_netcdf")},
}


def missing_attribute(owner: object, name: str, message: str) -> object:
    """Raise an AttributeError with a message, or the error of the property that has failed."""
    if not name.startswith("_") and hasattr(type(owner), name):
        return object.__getattribute__(owner, name)
    raise AttributeError(message)


class AnswersGuesses:
    """A result that answers attributes and keys which it does not have.

    Attributes
    ----------
    noun : the result in a word, as users may name it
    instead : what to write instead of names that other packages use
    """

    noun: ClassVar[str]
    instead: ClassVar[Mapping[str, str]]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Raise an AttributeError that says what to write instead."""
            return missing_attribute(self, name, f"{self.noun} has no {name!r}{self._hint(name)}")

    def __getitem__(self, key: object) -> NoReturn:
        """Raise a TypeError that says what to write instead."""
        table = next(iter(self.instead.values()))
        raise TypeError(f"{self.noun} has no [{shown(key)}]: write {self.noun}.{table}")

    @classmethod
    def _hint(cls, name: str) -> str:
        """Return what to write instead of an attribute; it does not exist."""
        if replacement := cls.instead.get(name):
            return f": write {cls.noun}.{replacement}"
        attributes = [*getattr(cls, "__annotations__", {}), *dir(cls)]
        own = {"noun", "instead"}
        public = [each for each in dict.fromkeys(attributes) if each[0] != "_" and each not in own]
        if suggestion := nearest(name, public):
            return f": did you mean {cls.noun}.{suggestion}?"
        return f"; it has {', '.join(public)}"
