"""The errors of other programs' results as lines and tables of text, and the page of a check."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..crosscheck import DISAGREE, Account, Rows
from ..figures.scale import Scale
from .errors import QuantityError, quantity_errors
from .other_program import ASK_FOR_ROWS, ROWS

if TYPE_CHECKING:
    from ..figures.catalogue import Picture
    from .check import Check


# distance from the edge of a ring, over the punch radius, within which a mesh is to be fine
NEAR_EDGE = 0.05
# file of the figure of a refinement
REFINEMENT = "refinement.png"


class Banner(NamedTuple):
    """The judgement on the results of one program.

    Parameters
    ----------
    colour : class of the judgement in `page.css`
    word, sentence : the judgement in a few words, and in a sentence
    mistake : the most likely mistake, in a sentence; empty if there is none to name
    """

    colour: str
    word: str
    sentence: str
    mistake: str


class CheckAccount(Account):
    """All texts about a check: on the results of other programs, and then on our methods."""

    template: ClassVar[str] = "check.html.j2"

    def __init__(self, check: "Check") -> None:
        super().__init__(check.together)
        self.check, self.scale = check, Scale.of(check.together)

    @property
    def allowed(self) -> str:
        """The allowed error, in per cent."""
        return f"{100 * self.check.within:.3g} %"

    @property
    def brief(self) -> list[str]:
        """The title, the errors of the other programs, and the verdict on our methods."""
        verdict = f"Our own methods: {self.verdict_line}"
        return [self.title, "", *self.lines, "", verdict, *self.warnings]

    @property
    def lines(self) -> list[str]:
        """The judgement on the other programs in sentences."""
        lines = list[str]()
        for name in self.check.judged:
            errors = map(str, self.errors_of(name))
            lines += [f"{name}: {line}" for line in (self.judgement_on(name), *errors)]
        return lines + self.refinement

    @property
    def refinement(self) -> list[str]:
        """The convergence of each quantity, in sentences; empty without a refinement."""
        return [f"refinement: {row.in_words(self.names)}" for row in self.check.refinements]

    @property
    def mistakes(self) -> list[str]:
        """The mistakes that may explain the errors, the most likely first; this takes seconds."""
        return [
            f"{name}: {mistake}" for name in self.check.judged for mistake in self.mistakes_of(name)
        ]

    def mistakes_of(self, program: str) -> list[str]:
        """Return sentences on the mistakes that may explain the errors of a program."""
        return [mistake.words for mistake in self.check.mistakes(program)]

    def errors_of(self, program: str) -> list[QuantityError]:
        """Return the errors of each quantity of a program."""
        return quantity_errors(self.check.rows_of(program), self.scale)

    def next_step(self, program: str) -> str:
        """Return where the error of a program is greatest, and what to do about it."""
        worst = max(self.errors_of(program), key=lambda each: each.excess)
        line = f"the {str(worst).partition(' (our')[0]}"
        place = worst.at_one_radius or worst.place
        edges = self.scene.problem.ring_edges[1:] * self.scene.problem.units.length
        near = np.abs(edges - worst.largest.radius).min() < NEAR_EDGE * edges[-1]
        at_edge = worst.largest.quantity == "pressure" and near
        # decks solve single states, without updates of the wear
        few_rows = (
            worst.largest.quantity == "pressure"
            and not self.check.decks.get(program)
            and len(self.check.compared(program).times) < ROWS
        )
        return (
            f"{line}{f', at {place}' if place else ''}"
            f"{', as with a coarse mesh at an edge' if at_edge else ''}; give two results on finer "
            "meshes with --refinement: errors of a mesh decrease, and wrong inputs do not"
            f"{f'; {ASK_FOR_ROWS}' if few_rows else ''}"
        )

    def judgement_on(self, program: str) -> str:
        """Return a sentence on whether all quantities of a program are within the allowed error."""
        check, rows = self.check, self.check.rows_of(program)
        exceeding = dict.fromkeys(row.quantity for row in rows if not row.within)
        quantities = dict.fromkeys(row.quantity for row in rows)
        if not rows:
            return "none of its results could be compared"
        if not exceeding:
            line = f"all {len(quantities)} quantities are within {check.within:.3g} of ours"
            unsure = ", ".join(each.replace("_", " ") for each in check.undecided_on(program))
            return f"{line}, or within our own error estimate: {unsure}" if unsure else line
        names = ", ".join(name.replace("_", " ") for name in exceeding)
        counts = f"{len(exceeding)} of {len(quantities)} quantities"
        return f"{counts} differ from ours by more than {check.within:.3g}: {names}"

    @property
    def banners(self) -> list[Banner]:
        """The judgement on each program whose results are judged."""
        banners, check = [], self.check
        for name in check.judged:
            within, mistakes = check.is_within(name), self.mistakes_of(name)
            colour, word = "disagree", f"not within {self.allowed}"
            if not check.rows_of(name):
                colour, word = "undecided", "not compared"
            elif within:
                colour, word = "agree", f"within {self.allowed}"
            sentence, mistake = f"{name}: {self.judgement_on(name)}.", ""
            if within and check.undecided_on(name):
                colour, word = "undecided", "undecided"
            if within and check.result.verdict == DISAGREE:
                colour = "undecided"
                sentence += " But our own methods disagree, so that this proves nothing."
            if mistakes and not within:
                mistake = f"{mistakes[0][0].upper()}{mistakes[0][1:].rstrip('.')}."
            banners.append(Banner(colour, word, sentence, mistake))
        return banners

    @property
    def errors(self) -> Rows:
        """A row for each quantity of each program: its greatest error, where it is, and ours."""
        check = self.check
        return [
            ({"results": name} if len(check.judged) > 1 else {})
            | {
                "quantity": error.quantity,
                f"within {self.allowed}": "yes" if error.within else "NO",
                "greatest error": error.error,
                "at": error.place,
                "our error estimate": error.estimate.removeprefix("our error estimate: "),
                "largest error at one radius": error.at_one_radius,
            }
            for name in check.judged
            for error in self.errors_of(name)
        ]

    def first_figures(self, pictures: Iterable["Picture"]) -> list[str]:
        """Return the files of the figures that show the checked results."""
        return [picture.file for picture in pictures if shows_others(self.check, picture)]


def shows_others(check: "Check", picture: "Picture") -> bool:
    """Return whether a figure shows the results of other programs."""
    solutions = check.together.solutions
    given = {name for program in check.judged for name in solutions[program].results}
    return picture.file == REFINEMENT or bool(given.intersection(picture.quantities))
