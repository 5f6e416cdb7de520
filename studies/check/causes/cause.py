"""The base classes of mistakes: each changes the setting, and has a sentence and a remedy."""

from abc import ABC, abstractmethod
from typing import ClassVar

from .model import Model
from .setting import Setting

Sizes = tuple[float, ...]
# factors at which the search for a factor begins
INITIAL_FACTORS = (0.1, 0.4, 0.8, 1.25, 2.5, 10.0)


class Cause(ABC):
    """A mistake that people often make.

    A cause has sizes: the numbers that describe the mistake, such as a factor. Some have none.

    Attributes
    ----------
    name : of the mistake
    prior : odds of this mistake against no mistake, before the results are seen
    fitted_numbers : number of sizes that are fitted to the results
    searched : whether the sizes are optimised, beginning at each candidate; otherwise the
        candidates are the only sizes
    choices : number of values among which the prior is divided, if none is fitted
    is_of_mesh : whether a right model has this error, too, if its mesh is too small or too coarse
    group : mistakes of the same group are never combined
    remedy : what the user can do to confirm the mistake
    """

    name: ClassVar[str]
    prior: ClassVar[float]
    fitted_numbers: ClassVar[int] = 0
    searched: ClassVar[bool] = False
    choices: ClassVar[int] = 1
    is_of_mesh: ClassVar[bool] = False
    group: ClassVar[str]
    remedy: ClassVar[str]

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return True

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at; one empty tuple if there are none."""
        return [()]

    @abstractmethod
    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""

    @abstractmethod
    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""

    def name_of(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake at these sizes."""
        return self.name

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that is reported for the mistake."""
        return sizes[0] if sizes else 1.0

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes lie in the range that is considered."""
        return True


class Factor(Cause):
    """A mistake that multiplies something by a factor, which is fitted.

    Attributes
    ----------
    greatest_factor : the factor lies between the inverse of this number and this number
    """

    searched = True
    fitted_numbers = 1
    greatest_factor: ClassVar[float] = 1e9

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the factors at which the search begins."""
        return [(factor,) for factor in INITIAL_FACTORS]

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether the factor lies in the range that is considered."""
        return 1 / self.greatest_factor < sizes[0] < self.greatest_factor
