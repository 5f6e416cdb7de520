"""What a sweep has found, in sentences."""

from pathlib import Path

import xarray

from .template import DONE, FAILED, PENDING

# greatest number of different reasons that are printed
MOST_REASONS = 10


def conclude(dataset: xarray.Dataset, out: Path) -> tuple[list[str], bool, bool]:
    """Return lines on the scenes of a sweep, and whether all are done, and whether methods agree.

    Parameters
    ----------
    dataset : results of all scenes
    out : folder of the store
    """
    status, reasons = dataset["status"].values, dataset["reason"].to_series()
    finished, failed, pending = (int((status == flag).sum()) for flag in (DONE, FAILED, PENDING))
    lines = [f"{finished} scenes finished, {failed} failed, {pending} left: see {out}"]
    for reason, count in reasons[reasons != ""].value_counts().head(MOST_REASONS).items():
        lines.append(f"{reason} ({count} scenes)")
    if failed or pending:
        lines.append("--resume computes the scenes left, --retry-failed also those that failed")
    disagreeing = int((dataset["disagreement"] > 1).sum()) if "disagreement" in dataset else 0
    if disagreeing:
        lines.append(f"methods disagree in {disagreeing} scenes")
    return lines, not (failed or pending), not disagreeing
