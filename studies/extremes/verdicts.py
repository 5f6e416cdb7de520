"""The verdicts on a run, from the best to the worst.

within      the error is at most the method's own estimate, and at most ten times the tolerance
degraded    the error is at most the estimate, but above ten times the tolerance; or it is above
            the estimate, but at most three times the estimate or within the tolerance
refused     a RingwearError states why the run is not possible
wrong       the error is above the tolerance and above three times the estimate: a defect
crashed     any other exception or a RuntimeWarning: a defect
"""

import sys
import warnings
from collections.abc import Callable, Iterable
from typing import Any

from ..crosscheck import RingwearError

MEANINGS = {
    "within": "the error is within the estimate",
    "degraded": "less accurate than the tolerance, and reported so",
    "refused": "with a reason",
    "wrong": "less accurate than reported",
    "crashed": "any other exception",
}
"""Meaning of each verdict for legends, from the best to the worst."""

Verdict = dict[str, Any]
"""The columns `verdict`, `quantity`, `error` and `estimate`, or `verdict` and `message`."""


def verdict_on(quantity: str, error: float, estimate: float, rtol: float) -> Verdict:
    """Return the verdict on a quantity of a cell of the map.

    Parameters
    ----------
    quantity : its name
    error : its true relative error
    estimate : its relative error as the method estimates it
    rtol : tolerance
    """
    if error <= estimate:
        verdict = "within" if error <= 10 * rtol else "degraded"
    else:
        verdict = "degraded" if error <= max(rtol, 3 * estimate) else "wrong"
    return {"verdict": verdict, "quantity": quantity, "error": error, "estimate": estimate}


def verdict_on_promise(quantity: str, error: float, estimate: float, rtol: float) -> Verdict:
    """Return the verdict on a quantity of a panel, whose accuracy the method promises.

    In contrast to `verdict_on`, an error within the tolerance gives the verdict `within` whatever
    the estimate, because the tolerance is the promise. The parameters are those of `verdict_on`.
    """
    verdict_if_missed = "degraded" if error <= 3 * estimate else "wrong"
    return {
        "verdict": "within" if error <= rtol else verdict_if_missed,
        "quantity": quantity,
        "error": error,
        "estimate": estimate,
    }


def rank_by_error(judged: Verdict) -> tuple[int, float]:
    """Return a sort key of verdicts: by the verdict, then by the error."""
    return list(MEANINGS).index(judged["verdict"]), judged["error"]


def rank(judged: Verdict) -> tuple[int, float]:
    """Return a sort key of verdicts: by the verdict, then by the error over its estimate."""
    # exact values, such as a scene key that is passed on, have an estimate of zero
    estimate = max(judged["estimate"], sys.float_info.min)
    return list(MEANINGS).index(judged["verdict"]), judged["error"] / estimate


def worst_of(
    judge: Callable[[], Iterable[Verdict]], rank: Callable[[Verdict], tuple[int, float]] = rank
) -> Verdict:
    """Return the worst verdict on a run, or `refused` or `crashed` with the message.

    Parameters
    ----------
    judge : function that runs and judges; it may raise
    rank : sort key of verdicts
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            return max(judge(), key=rank)
    except RingwearError as error:
        return {"verdict": "refused", "message": str(error)}
    except Exception as error:  # the study looks for any other exception
        return {"verdict": "crashed", "message": f"{type(error).__name__}: {error}"}


def in_words(counts: dict[str, int], runs: str) -> str:
    """Return the headline: the number of runs with each verdict.

    Parameters
    ----------
    counts : number of runs by verdict
    runs : name of the runs, in the plural
    """
    return (
        f"{sum(counts.values())} {runs}: {counts['wrong']} wrong, {counts['crashed']} crashed, "
        f"{counts['refused']} refused with a reason, {counts['degraded']} less accurate than the "
        f"tolerance, and reported so"
    )
