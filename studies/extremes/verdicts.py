"""The verdicts on a run, from the best to the worst.

within      the error is within the method's own estimate, and not above ten times the accuracy
            asked for
degraded    the error is above ten times that accuracy, within the estimate; or the estimate
            falls short of it by less than three times, or it is at least within that accuracy
refused     a RingwearError says why not
wrong       the error is beyond both, and nothing says so: a defect
crashed     any other exception or a RuntimeWarning: a defect
"""

import sys
import warnings
from collections.abc import Callable, Iterable
from typing import Any

from ...meshes.errors import RingwearError

MEANINGS = {
    "within": "its error is within its own estimate",
    "degraded": "less accurate than asked for, and says so",
    "refused": "says why it cannot",
    "wrong": "less accurate than it says",
    "crashed": "by any other exception",
}
"""What each verdict means, from the best to the worst."""

Verdict = dict[str, Any]
"""The columns `verdict`, `quantity`, `error` and `estimate`, or `verdict` and `message`."""


def verdict_on(quantity: str, error: float, estimate: float, rtol: float) -> Verdict:
    """Return the verdict on a number, in the words of `MEANINGS`.

    Parameters
    ----------
    quantity : name of the number
    error : its true relative error
    estimate : the relative error that the method states
    rtol : the accuracy asked for
    """
    if error <= estimate:
        verdict = "within" if error <= 10 * rtol else "degraded"
    else:
        verdict = "degraded" if error <= max(rtol, 3 * estimate) else "wrong"
    return {"verdict": verdict, "quantity": quantity, "error": error, "estimate": estimate}


def verdict_on_promise(quantity: str, error: float, estimate: float, rtol: float) -> Verdict:
    """Return whether the promise of an accuracy was kept, or that it was not was said.

    Unlike `verdict_on`, an error below the accuracy asked for is within, whatever was stated: that
    accuracy is what is promised.
    """
    verdict = "degraded" if error <= 3 * estimate else "wrong"
    return {
        "verdict": "within" if error <= rtol else verdict,
        "quantity": quantity,
        "error": error,
        "estimate": estimate,
    }


def rank_by_error(judged: Verdict) -> tuple[int, float]:
    """Return how bad a quantity is: by its verdict, then by its error."""
    return list(MEANINGS).index(judged["verdict"]), judged["error"]


def rank(judged: Verdict) -> tuple[int, float]:
    """Return how bad a quantity is: by its verdict, then by its error over the estimate."""
    # what is exact, such as a key that is passed on, has an estimate of zero
    estimate = max(judged["estimate"], sys.float_info.min)
    return list(MEANINGS).index(judged["verdict"]), judged["error"] / estimate


def worst_of(
    judge: Callable[[], Iterable[Verdict]], rank: Callable[[Verdict], tuple[int, float]] = rank
) -> Verdict:
    """Return the worst of the verdicts of a run, or that it refused or crashed, and why."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            return max(judge(), key=rank)
    except RingwearError as error:
        return {"verdict": "refused", "message": str(error)}
    except Exception as error:  # whatever else comes out is what the study looks for
        return {"verdict": "crashed", "message": f"{type(error).__name__}: {error}"}


def in_words(counts: dict[str, int], what: str) -> str:
    """Return the headline: how many runs have each verdict."""
    return (
        f"{sum(counts.values())} {what}: {counts['wrong']} wrong, {counts['crashed']} crashed, "
        f"{counts['refused']} refused with a reason, {counts['degraded']} less accurate than "
        f"asked for, and said so"
    )
