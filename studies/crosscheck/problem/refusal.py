"""Why a method cannot solve a problem, and the features of problems that methods may refuse."""

from typing import Literal, NamedTuple

Feature = Literal[
    "wear along the radius", "moving contact", "fixed indentation", "varying load", "layers"
]
"""A feature of a problem that not every method can solve (`Problem.features`)."""


class Refusal(NamedTuple):
    """Why a method cannot solve a kind of problem, and what to write instead.

    Parameters
    ----------
    reason : str
        The reason, a clause.
    remedy : str
        What to write in the scene instead.
    """

    reason: str
    remedy: str = "leave it out of methods"

    def __str__(self) -> str:
        """Return the reason and the remedy in one line."""
        return f"{self.reason}: {self.remedy}"
