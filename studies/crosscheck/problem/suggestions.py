"""Suggest which of our names is meant by another one."""

import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING

# least similarity (difflib ratio) of an unknown name to the suggested one
LEAST_SIMILARITY = 0.6


def nearest(word: str, words: Iterable[str], similarity: float = LEAST_SIMILARITY) -> str:
    """Return the most similar of some words, ignoring case; empty if none is similar."""
    by_lower = {candidate.lower().replace("-", "_"): candidate for candidate in words}
    lower = word.lower().replace("-", "_").replace(" ", "_")
    matches = difflib.get_close_matches(lower, by_lower, 1, similarity)
    if not matches and len(word) > 2:
        matches = [candidate for candidate in by_lower if lower in candidate]
    return by_lower[matches[0]] if matches else ""


def did_you_mean(word: object, words: Iterable[str], otherwise: str = "", quote: str = "'") -> str:
    """Return the end of an error message about an unknown word.

    It asks whether the most similar of some words is meant, if one is similar, and says what to do
    otherwise. Words that are not texts, such as names of keys and files, have no quotes.
    """
    if match := nearest(str(word), words):
        meant = f"{quote}{match}{quote}"
        return f": did you mean {meant}?{f' Otherwise {otherwise}' if otherwise else ''}"
    return f": {otherwise}" if otherwise else ""


class AnswersGuesses:
    """An object that suggests its nearest attribute for one that it does not have."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Raise an AttributeError that suggests an attribute."""
            if name.startswith("_") or hasattr(type(self), name):
                # there is no such attribute, or its property has failed: raise that error
                return object.__getattribute__(self, name)
            noun, meant = type(self).__name__.lower(), self._nearest(name)
            hint = f"did you mean {noun}.{meant}?" if meant else f"see dir({noun})"
            raise AttributeError(f"{noun} has no {name!r}: {hint}")

    def _nearest(self, name: str) -> str:
        """Return the most similar public attribute; empty if none is similar."""
        return nearest(name, (each for each in dir(self) if not each.startswith("_")))
