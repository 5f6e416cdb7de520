"""The paper's claims beside our values: a table whose every number and verdict is computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper with a number or a trend in it, and what we find.

    Parameters
    ----------
    place : section or figure
    says : the sentence, shortened
    value : what we compute for it
    uncertainty : of our value, and how it is known
    holds : whether the sentence is true
    remark : why it is not, or what has to be added
    """

    place: str
    says: str
    value: str
    uncertainty: str
    holds: bool
    remark: str = ""

    @property
    def verdict(self) -> str:
        if not self.holds:
            return "does not hold"
        return "holds with a remark" if self.remark else "holds"


PRINT_ERRORS = (
    ("Eq. 3", "holds for `f(0) = 0` only; a worn centre adds `f(0)`: here `g(x) = f(0) + x int_0^x f'/sqrt(x^2 - r^2) dr`, "
              "which in contact is `d - q(x)/E*`"),
    ("Eq. 7", "the integral to infinity must include the jump of `q` at `x = a`, which yields the edge term "
              "`q(a)/(pi sqrt(a^2 - r^2))`: without it a flat punch would have no pressure at all"),
    ("Eq. 18", "does not say over what the average is taken: here over the radius (`line`, the default) and over the area "
               "(`area`), both told everywhere"),
    ("Eq. 25", "integrates over the angle twice, by the factor `2 pi` and by the inner integral; Eq. 26 is right"),
    ("Fig. 7, text", "\"if the share of slower wearing material is increased, the surface gradient is significantly "
                     "higher\": it is where the share is *decreased*, as the next sentence on `h2/h1 = 0.1` shows"),
)  # fmt: skip


def document(claims: Sequence[Claim], definitions: Sequence[str]) -> str:
    """The claims and the print errors in Markdown."""
    lines = ["# The paper's claims, checked", "", *definitions, ""]
    lines += [
        "| where | the paper says | we find | uncertainty | verdict | why, or what to add |",
        "|---|---|---|---|---|---|",
    ]
    for claim in claims:
        cells = (claim.place, claim.says, claim.value, claim.uncertainty, f"**{claim.verdict}**", claim.remark)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    lines += ["", "## Print errors handled here", ""]
    lines += [f"- {place}: {what}." for place, what in PRINT_ERRORS]
    return "\n".join(lines) + "\n"


def told(values: dict[int, float], form: str = ".3f") -> str:
    """Values by number of rings, in a line."""
    return ", ".join(f"{value:{form}} (N = {rings})" for rings, value in values.items())


def tally(claims: Sequence[Claim]) -> str:
    """How many claims have which verdict, in a line."""
    verdicts = [claim.verdict for claim in claims]
    kinds = ("holds", "holds with a remark", "does not hold")
    return "claims: " + ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in kinds)
