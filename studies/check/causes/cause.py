"""What a mistake is: a change of the setting with one number, a sentence and a remedy."""

from abc import ABC, abstractmethod
from typing import ClassVar

from .model import Model
from .setting import Setting

Sizes = tuple[float, ...]
# factors from which a search for one begins
FACTORS = (0.1, 0.4, 0.8, 1.25, 2.5, 10.0)


class Cause(ABC):
    """A mistake that people make.

    Attributes
    ----------
    name : of the mistake
    prior : odds of it, before the results are seen, against there being none
    fitted : how many numbers are fitted
    searched : whether they are searched for from each candidate; else the candidates are all
    choices : among how many values the prior is shared, if none is fitted
    group : mistakes of one group are not made together
    remedy : what would confirm it
    """

    name: ClassVar[str]
    prior: ClassVar[float]
    fitted: ClassVar[int] = 0
    searched: ClassVar[bool] = False
    choices: ClassVar[int] = 1
    group: ClassVar[str]
    remedy: ClassVar[str]

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return True

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from; one without numbers if it has none."""
        return [()]

    @abstractmethod
    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""

    @abstractmethod
    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""

    def named(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake of this size."""
        return self.name

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that people know it by."""
        return sizes[0] if sizes else 1.0

    def within(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes are possible."""
        return True


class Factor(Cause):
    """A mistake that multiplies something by a number, which is searched for.

    Attributes
    ----------
    greatest : factor that is possible, and the inverse of the least
    """

    searched = True
    fitted = 1
    greatest: ClassVar[float] = 1e9

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the factors that a search begins from."""
        return [(factor,) for factor in FACTORS]

    def within(self, model: Model, sizes: Sizes) -> bool:
        """Return whether a factor is possible."""
        return 1 / self.greatest < sizes[0] < self.greatest
