"""Read results back from the folder that they were written to."""

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pydantic import TypeAdapter, ValidationError

from ....meshes.errors import SceneError
from ...tables.writing import json_text
from ..anchors.anchor import Anchor
from ..problem.quantities import ANSWER, QUANTITIES, STEPS, error_name
from ..problem.written import shown
from ..progress import LOG
from ..registry import METHODS
from ..scene.scene import Scene
from ..verdict.agreement import Agreement
from ..verdict.promise import LeftOut
from .output.answer import Answers
from .output.checksums import Json
from .output.netcdf import RESULTS, SUMMARY
from .output.saved_files import Unreadable, read_folder, refused
from .result import Result, methods_with_fields
from .scope import methods_of

if TYPE_CHECKING:
    import xarray

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
    verdict, notes : as in `Result`
    methods : sizes and costs of each method
    answer : numbers of the answer, by method and name; None for those that are not finite
    agreement, anchors, left_out_of_promise : rows of objects
    check : whether results of other programs pass, and the judgement on them in sentences
    errors, verdicts : rows of their errors; the second name is that of older results
    """

    verdict: Literal["agree", "disagree", "undecided"]
    notes: tuple[str, ...]
    methods: dict[str, Json]
    answer: dict[str, dict[str, Number | list[Number] | list[list[Number]]]]
    agreement: tuple[Agreement, ...]
    anchors: tuple[Anchor, ...]
    left_out_of_promise: tuple[LeftOut, ...] = ()
    check: Json = field(default_factory=dict)
    errors: tuple[Json, ...] = ()
    verdicts: tuple[Json, ...] = ()

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of the programs whose results were checked."""
        rows = self.errors or self.verdicts
        return tuple(dict.fromkeys(str(row.get("solver")) for row in rows))


def load(folder: str | Path) -> Result:
    """Read the results that ``ringwear run --out folder``, or `Result.save`, has written.

    They have all numbers, and the figures that need only these. Both files are compared with the
    checksums in `summary.json`. Results that were saved without checksums are read, too, with the
    warning that they could not be checked.

    Raises
    ------
    SceneError
        if the folder contains no results that can be read, or if they do not match their
        checksums; the message names what does not match
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
        answers = Answers.read(summary.answer)
    except (Unreadable, ValueError, RecursionError) as error:
        raise refused(path, error) from None
    if not has_checksums:
        LOG.warning("%s: %s", path, UNCHECKED)
    return Result(
        scene,
        methods_of([name for name in summary.methods if name in METHODS]),
        dataset,
        answers,
        summary.agreement,
        summary,
        summary.notes,
        of_others=summary.of_others,
        about_others=tuple(summary.check.get("lines", ())),
        compared_in_fields=methods_with_fields(dataset),
        saved=entries,
        about_files=() if has_checksums else (UNCHECKED,),
    )


def _rebuild(entries: Json) -> Summary:
    """Return the typed entries of `summary.json`.

    Raises
    ------
    Unreadable
        if an entry is missing or has a wrong type
    """
    try:
        return _validator().validate_json(json_text(entries), strict=True)
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
    if different := Answers.read(summary.answer).first_difference(dataset):
        raise Unreadable(
            f"{different} in {SUMMARY} is not that in {RESULTS}, so that the files belong to two "
            "runs"
        )
