"""The verdict on results of other programs as lines and tables of text, for the page of a check."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from ..crosscheck.result.words import Account, Rows
from ..crosscheck.verdict.agreement import DISAGREE
from ..figures.scale import Scale
from .verdict import quantity_errors

if TYPE_CHECKING:
    from ..figures.style import Picture
    from .checked import CheckedOutcome


class Banner(NamedTuple):
    """The verdict on the results of one program.

    Parameters
    ----------
    colour : class of the verdict in `page.css`
    word, sentence : the verdict in a few words, and in a sentence
    mistake : the most likely mistake, in a sentence; empty if there is none to name
    """

    colour: str
    word: str
    sentence: str
    mistake: str


class CheckAccount(Account):
    """All texts about a check: on the results of other programs, and then on our methods."""

    template: ClassVar[str] = "check.html.j2"
    result: "CheckedOutcome"

    @property
    def allowed(self) -> str:
        """The allowed error, in per cent."""
        return f"{100 * self.result.within:.3g} %"

    @property
    def banners(self) -> list[Banner]:
        """The verdict on each program whose results are judged."""
        banners, result = [], self.result
        for name in result.judged:
            within, mistakes = result.is_within(name), result.mistakes_of(name)
            colour, word = "disagree", f"not within {self.allowed}"
            if not result.verdicts_on(name):
                colour, word = "undecided", "not compared"
            elif within:
                colour, word = "agree", f"within {self.allowed}"
            sentence, mistake = f"{name}: {result.verdict_on(name)}.", ""
            if within and result.undecided_on(name):
                colour, word = "undecided", "undecided"
            if within and result.verdict == DISAGREE:
                colour = "undecided"
                sentence += " But our own methods disagree, so that this proves nothing."
            if mistakes and not within:
                mistake = f"{mistakes[0][0].upper()}{mistakes[0][1:].rstrip('.')}."
            banners.append(Banner(colour, word, sentence, mistake))
        return banners

    @property
    def errors(self) -> Rows:
        """A row for each quantity of each program: its greatest error, where it is, and ours."""
        scale, result = Scale.of(self.result), self.result
        return [
            ({"results": name} if len(result.judged) > 1 else {})
            | {
                "quantity": error.quantity,
                f"within {self.allowed}": "yes" if error.within else "NO",
                "greatest error": error.error,
                "at": error.place,
                "our error estimate": error.estimate.removeprefix("our error estimate: "),
                "largest error at one radius": error.at_one_radius,
            }
            for name in result.judged
            for error in quantity_errors(result.verdicts_on(name), scale)
        ]

    @property
    def mistakes(self) -> list[str]:
        """The mistakes that may explain the errors, the most likely first."""
        return [
            f"{name}: {mistake}"
            for name in self.result.judged
            for mistake in self.result.mistakes_of(name)
        ]

    def first_figures(self, pictures: Iterable["Picture"]) -> list[str]:
        """Return the files of the figures that show the checked results."""
        return [picture.file for picture in pictures if self.result.shows_others(picture)]
