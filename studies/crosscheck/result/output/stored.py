"""Read results back from the folder that they were written to."""

import json
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError

from .....meshes.errors import SceneError
from .....meshes.radial import Array
from ...anchors.anchor import Anchor
from ...problem.quantities import ANSWER, QUANTITIES, STEPS, error_name
from ...problem.written import shown
from ...progress import LOG
from ...registry import METHODS
from ...scene.scene import Scene
from ...verdict.agreement import Agreement
from ...verdict.promise import LeftOut
from ..answer import Answers
from ..outcome import Outcome
from ..scope import methods_of
from .checksums import Json
from .netcdf import RESULTS, SUMMARY
from .saved_files import Unreadable, read_folder, refused

if TYPE_CHECKING:
    import xarray

Kind = TypeVar("Kind", bound="StoredOutcome")
Number = float | None
UNCHECKED = (
    "these results were saved without checksums, so that it could not be checked whether their "
    "files were changed"
)


@dataclass(frozen=True)
class Summary:
    """The entries of `summary.json` from which results are rebuilt.

    Parameters
    ----------
    verdict, notes : as in `Outcome`
    methods : sizes and costs of each method
    answer : numbers of the answer, by method and name; None for those that are not finite
    agreement, anchors, left_out_of_promise : rows of objects
    verdicts : rows of results of other programs that were checked
    """

    verdict: Literal["agree", "disagree", "undecided"]
    notes: tuple[str, ...]
    methods: dict[str, Json]
    answer: dict[str, dict[str, Number | list[Number] | list[list[Number]]]]
    agreement: tuple[Agreement, ...]
    anchors: tuple[Anchor, ...]
    left_out_of_promise: tuple[LeftOut, ...] = ()
    verdicts: tuple[Json, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class StoredOutcome(Outcome):
    """Results from a folder: all numbers, and the figures that need only these.

    Parameters
    ----------
    stored_dataset : the content of `results.nc`
    stored_summary : the content of `summary.json` without its checksums
    rebuilt : the entries of it from which results are rebuilt
    remarks_on_files : what to say about the files, such as that they have no checksums
    """

    stored_dataset: "xarray.Dataset"
    stored_summary: Json
    rebuilt: Summary
    remarks_on_files: tuple[str, ...]

    @cached_property
    def dataset(self) -> "xarray.Dataset":
        """The content of `results.nc`."""
        return self.stored_dataset

    @property
    def summary(self) -> Json:
        """The content of `summary.json` without its checksums."""
        return self.stored_summary

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of the programs whose results were checked."""
        return tuple(dict.fromkeys(str(row.get("solver")) for row in self.rebuilt.verdicts))

    @property
    def about_others(self) -> tuple[str, ...]:
        """The verdict on the results of other programs, in sentences; empty if there are none."""
        return tuple(self.stored_summary.get("check", {}).get("lines", ()))

    @property
    def verdict(self) -> str:
        """The verdict in `summary.json`: `agree`, `disagree` or `undecided`."""
        return self.rebuilt.verdict

    @property
    def left_out_of_promise(self) -> tuple[LeftOut, ...]:
        """Quantities that could not be promised, with the times and the reason."""
        return self.rebuilt.left_out_of_promise

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of all methods, and the remarks on the files."""
        return (*self.rebuilt.notes, *self.remarks_on_files)

    @cached_property
    def answers(self) -> dict[str, dict[str, Array]]:
        """The numbers of the answer, by method, and their relative error estimates."""
        return _answers(self.rebuilt)

    @property
    def anchors(self) -> tuple[Anchor, ...]:
        """Closed forms and conservation laws that the report of each method was checked against."""
        return self.rebuilt.anchors


def _answers(summary: Summary) -> Answers:
    """Return the numbers of the answer by method and name; NaN for those that are not finite.

    Raises
    ------
    Unreadable
        if the rows of one of them have several lengths
    """
    answers = Answers()
    for method, numbers in summary.answer.items():
        answers[method] = {}
        for name, value in numbers.items():
            try:
                answers[method][name] = np.array(value, dtype=float)
            except ValueError:
                raise Unreadable(f"{name} of {method} in {SUMMARY} is no array") from None
    return answers


def load(folder: str | Path, kind: type[Kind]) -> Kind:
    """Read the results that ``ringwear run --out folder``, or `Result.save`, has written.

    Parameters
    ----------
    folder : the folder with the results
    kind : class of the results, such as `Stored`, which can draw itself

    Raises
    ------
    SceneError
        if the folder contains no results that can be read, or if they do not match their
        checksums
    """
    if not isinstance(folder, str | Path):
        raise SceneError(f"{shown(folder)} is no folder: give one that `ringwear run` has written")
    path = Path(folder)
    dataset, entries, has_checksums = read_folder(path)
    try:
        summary = _rebuild(entries)
        if not has_checksums:
            _refuse_malformed(dataset)
            _refuse_mixed(dataset, summary)
        scene = Scene.from_toml(_text(dataset, "scene"), str(path))
    except (Unreadable, RecursionError) as error:
        raise refused(path, error) from None
    methods = methods_of([name for name in summary.methods if name in METHODS])
    remarks = () if has_checksums else (UNCHECKED,)
    for remark in remarks:
        LOG.warning("%s: %s", path, remark)
    rows = summary.agreement
    return kind(scene, methods, {}, {}, rows, (), dataset, entries, summary, remarks)


def _rebuild(entries: Json) -> Summary:
    """Return the typed entries of `summary.json`.

    Raises
    ------
    Unreadable
        if an entry is missing or has a wrong type
    """
    try:
        return _validator().validate_json(json.dumps(entries), strict=True)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        # pydantic adds the type that it has tried, such as list[float]
        loc = (str(part) for part in fault["loc"])
        place = ".".join(part for part in loc if part != "float" and "[" not in part)
        reason = fault["msg"].replace("Input should", "it should").replace("Field r", "r")
        raise Unreadable(f"{SUMMARY} is malformed at {place}: {reason}") from None


@cache
def _validator() -> TypeAdapter[Summary]:
    return TypeAdapter(Summary)


def _text(dataset: "xarray.Dataset", name: str) -> str:
    """Return an attribute of `results.nc`.

    Raises
    ------
    Unreadable
        if there is none, or if it is no text
    """
    text = dataset.attrs.get(name)
    if not isinstance(text, str):
        raise Unreadable(f"{RESULTS} has no attribute {name}")
    return text


def _refuse_malformed(dataset: "xarray.Dataset") -> None:
    """Raise if known arrays of a dataset have other dimensions or another type than ringwear's.

    Raises
    ------
    Unreadable
        with the name of the array
    """
    expected: dict[str, tuple[tuple[str, ...], str]] = {"solver": (("solver",), "U")}
    expected |= {"time": (("time",), "f"), "radius": (("radius",), "f")}
    for name, quantity in (QUANTITIES | STEPS | ANSWER).items():
        for variable, dims in ((name, quantity.dims), (error_name(name), quantity.error_dims)):
            if variable in dataset:
                expected[variable] = ("solver", *dims), "f"
    for name, (dims, kind) in expected.items():
        array = dataset.variables.get(name)
        if array is None or array.dims != dims or array.dtype.kind != kind:
            content = "texts" if kind == "U" else "numbers"
            raise Unreadable(f"{name} in {RESULTS} is no array of {content} over {', '.join(dims)}")


def _refuse_mixed(dataset: "xarray.Dataset", summary: Summary) -> None:
    """Raise if the numbers of the answer differ between the two files.

    Raises
    ------
    Unreadable
        with the name of the number
    """
    solvers = dataset["solver"].values.tolist()
    for entry, by_method in (("methods", summary.methods), ("answer", summary.answer)):
        if list(by_method) != solvers:
            raise Unreadable(
                f"{entry} in {SUMMARY} has the methods {', '.join(by_method) or 'none'}, and "
                f"{RESULTS} has {', '.join(solvers)}"
            )
    for method, values in _answers(summary).items():
        for name, value in values.items():
            if name not in dataset:
                continue
            row = dataset.variables[name].values[solvers.index(method)]
            if row.shape != value.shape or (row != value)[np.isfinite(value)].any():
                raise Unreadable(
                    f"{name} of {method} in {SUMMARY} is not that in {RESULTS}, so that the files "
                    "belong to two runs"
                )
