"""Read results back from the folder that they were written to."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from pydantic import TypeAdapter

from ....meshes.errors import SceneError
from ..anchors.anchor import Anchor
from ..problem.written import shown
from ..registry import METHODS
from ..scene.scene import Scene
from ..verdict.agreement import Agreement
from ..verdict.promise import LeftOut
from .output.files import Json, read_folder, refused
from .result import Result, methods_with_fields
from .scope import methods_of
from .table import answers_of


@dataclass(frozen=True)
class Summary:
    """The entries of `summary.json` from which results are rebuilt.

    Parameters
    ----------
    verdict, notes : as in `Result`
    methods : sizes and costs of each method
    agreement, anchors, left_out_of_promise : rows of objects
    check : whether results of other programs pass, and the judgement on them in sentences
    errors, verdicts : rows of their errors; the second name is that of older results
    """

    verdict: Literal["agree", "disagree", "undecided"]
    notes: tuple[str, ...]
    methods: dict[str, Json]
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
    checksums in `summary.json`.

    Raises
    ------
    SceneError
        if the folder contains no results, or if a file is not as it was written; the message names
        the file
    """
    if not isinstance(folder, str | Path):
        raise SceneError(f"{shown(folder)} is no folder: give one that `ringwear run` has written")
    path = Path(folder)
    table, entries = read_folder(path)
    try:
        summary = TypeAdapter(Summary).validate_python(entries)
    except ValueError as error:
        raise refused(path, error) from None
    return Result(
        Scene.from_toml(table.attrs["scene"], str(path)),
        methods_of([name for name in summary.methods if name in METHODS]),
        table,
        answers_of(table),
        summary.agreement,
        summary,
        summary.notes,
        of_others=summary.of_others,
        about_others=tuple(summary.check.get("lines", ())),
        compared_in_fields=methods_with_fields(table),
        saved=entries,
    )
