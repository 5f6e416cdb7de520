"""Suggest which of our names is meant by another one."""

import difflib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from .written import shown

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
    """A result that answers attributes and keys which it does not have.

    Attributes
    ----------
    noun : the result in a word, as users may name it
    instead : what to write instead of names that other packages use
    """

    noun: ClassVar[str]
    instead: ClassVar[Mapping[str, str]]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Raise an AttributeError that says what to write instead."""
            if name.startswith("_") or hasattr(type(self), name):
                # there is no such attribute, or its property has failed: raise that error
                return object.__getattribute__(self, name)
            raise AttributeError(f"{self.noun} has no {name!r}{self._hint(name)}")

    def __getitem__(self, key: Any) -> Any:
        """Raise a TypeError that says what to write instead."""
        table = next(iter(self.instead.values()))
        raise TypeError(f"{self.noun} has no [{shown(key)}]: write {self.noun}.{table}")

    @classmethod
    def _hint(cls, name: str) -> str:
        """Return what to write instead of an attribute; it does not exist."""
        attributes = [*getattr(cls, "__annotations__", {}), *dir(cls)]
        own = {"noun", "instead"}
        public = [each for each in dict.fromkeys(attributes) if each[0] != "_" and each not in own]
        known = {**dict.fromkeys(public, ""), **cls.instead}
        meant = name if name in known else nearest(name, known)
        if replacement := known.get(meant):
            return f": write {cls.noun}.{replacement}"
        return f": did you mean {cls.noun}.{meant}?" if meant else f"; it has {', '.join(public)}"
