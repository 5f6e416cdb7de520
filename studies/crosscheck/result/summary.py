"""The summary of a run, as it is written to `summary.json`."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ...tables.writing import as_json
from ..verdict.agreement import AGREE
from ..versions import package_versions
from .scope import left_out, modelled

if TYPE_CHECKING:
    from .result import Result


def summary(result: "Result") -> dict[str, Any]:
    """Return a summary of a run that can be written as JSON.

    It contains the verdict, the answer, cost and error estimates of each method, the agreement, the
    anchors, the scope of the model, the warnings and the notes.
    """
    scene, rtol = result.scene, result.scene.accuracy.rtol
    methods = {
        name: {
            "seconds": {
                stage: round(seconds, 6) for stage, seconds in result.stages[name].seconds.items()
            },
            "unknowns": solution.unknowns,
            "settings": solution.settings,
            "rtol_asked": rtol,
            "error_estimate": solution.error_estimate,
            "error_estimate_parts": solution.parts,
            "beyond_rtol": solution.beyond(rtol),
        }
        for name, solution in result.solutions.items()
    }
    entries = {
        "title": scene.title,
        "units": scene.units,
        "verdict": result.verdict,
        "quantities": result.quantities,
        "answer": result.answers,
        "methods": methods,
        "agreement": [
            asdict(row)
            # infinity, which a missing error estimate counts as, is read back as a number
            | {name: min(getattr(row, name), 1e99) for name in ("difference", "uncertainty")}
            | {"agrees": row.agrees}
            for row in result.agreement
        ],
        "agrees": result.verdict == AGREE,
        "left_out_of_promise": [asdict(row) for row in result.left_out_of_promise],
        "anchors": [asdict(anchor) | {"holds": anchor.holds} for anchor in result.anchors],
        "modelled": modelled(scene, result.methods),
        "left_out": left_out(scene, result.methods),
        "warnings": result.warnings,
        "notes": result.notes,
        "versions": package_versions(),
    }
    written: dict[str, Any] = as_json(entries)
    return written
