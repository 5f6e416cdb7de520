"""What an error looks like."""

from dataclasses import dataclass

from .comparison import Comparison


@dataclass(frozen=True)
class Diagnosis:
    """What an error looks like, and what would confirm it."""

    name: str
    size: float
    confidence: float
    words: str
    confirm: str


def diagnose(comparison: Comparison) -> list[Diagnosis]:
    """Return what the errors of a program look like."""
    del comparison
    return []
