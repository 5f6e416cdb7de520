"""A mistake that explains the difference of another program's results to ours, in words."""

from dataclasses import dataclass

import numpy as np

EXPLAINS, EQUALLY, REDUCES = "explains", "explain equally well", "reduces"
"""What is said about a mistake and the difference of two results."""


@dataclass(frozen=True)
class Diagnosis:
    """A mistake that may have been made.

    Parameters
    ----------
    name : of the mistake; empty if none that is known explains the difference
    size : number that describes the mistake, such as a factor
    judgement : "explains": what remains is within the estimated errors of both programs; "explain
        equally well": so does a rival; otherwise "reduces"
    looks_like : what the difference looks like, with the number, as a noun phrase
    before, remaining : greatest relative difference, and what remains with this mistake
    confirm : what would confirm the mistake; or, without one, where the greatest error is, and what
        to do next
    share : of the mistake among all that are known, by what remains, times the square of the part
        of the difference that it explains; no probability
    low, high : ends of its 95 % interval, if the mistake was made; NaN if it has no fitted number
    rival : another mistake that explains as much; empty if there is none
    program : whose results have the difference
    """

    name: str = ""
    size: float = np.nan
    judgement: str = ""
    looks_like: str = ""
    before: float = np.nan
    remaining: float = np.nan
    confirm: str = ""
    share: float = 1.0
    low: float = np.nan
    high: float = np.nan
    rival: str = ""
    program: str = ""

    @property
    def words(self) -> str:
        """All of this in a sentence."""
        if not self.name:
            return f"no mistake that we know explains the difference: {self.confirm}"
        interval = "" if np.isnan(self.low) else f" (95 %: {self.low:.4g} to {self.high:.4g})"
        if self.judgement == EQUALLY:
            return (
                f"{self.looks_like}{interval}: this and {self.rival} explain the difference "
                f"equally well. To confirm: {self.confirm}"
            )
        remains = f"{100 * self.remaining:.2g} %"
        says = f"explains the difference (what remains is {remains})"
        if self.judgement == REDUCES:
            says = (
                f"reduces the difference from {100 * self.before:.2g} % to {remains}, but does not "
                "explain it"
            )
        return f"{self.looks_like}{interval}, which {says}. To confirm: {self.confirm}"
