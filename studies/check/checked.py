"""A run beside which results of other programs stand: the verdict is on theirs."""

from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from ..outcome.outcome import Outcome
from ..problem.unit_names import UnitNames
from ..sampling.field_differences import OVER_TIME
from .diagnose import Comparison, Diagnosis, diagnose
from .verdict import Verdict, best, in_words, verdicts

if TYPE_CHECKING:
    import pandas as pd

    from .refinement import Refinement


@dataclass(frozen=True, eq=False, repr=False)
class CheckedOutcome(Outcome):
    """A run beside which results of other programs stand.

    Parameters
    ----------
    given : names of these
    within : relative error that they are allowed
    sizes : if they are of one program, from coarse to fine: the verdict is on the last; else empty
    """

    given: tuple[str, ...]
    within: float
    sizes: tuple[float, ...]

    @cached_property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Errors of theirs, by program, quantity and time."""
        return tuple(
            row
            for name in self.given
            for row in verdicts(self.scene, self.solutions, name, self.within)
        )

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of the programs whose results are checked."""
        return self.given

    @property
    def passes(self) -> bool:
        """Whether theirs is within what is allowed, by methods of ours that do not disagree."""
        judged = all(row.within for row in self.verdicts if row.solver in self.judged)
        return judged and self.verdict != "disagree"

    @property
    def compared_in_fields(self) -> tuple[str, ...]:
        """Ours that is known best, and those of theirs that give fields, the last of them first."""
        theirs = [name for name in reversed(self.judged) if self._fields_of(name)]
        ours = best(self.solutions, self._fields_of(theirs[0])[0]) if theirs else ""
        return (ours, *theirs) if ours else ()

    def _fields_of(self, name: str) -> list[str]:
        """Return the fields over time that a program gives."""
        return [field for field in OVER_TIME if field in self.solutions[name].results]

    @property
    def errors(self) -> "pd.DataFrame":
        """The verdicts as a table: a row for each program, quantity and time."""
        import pandas as pd

        return pd.DataFrame([asdict(row) for row in self.verdicts])

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of those that are judged."""
        return self.given[-1:] if self.sizes else self.given

    @cached_property
    def refinements(self) -> "tuple[Refinement, ...]":
        """How theirs converges, by quantity."""
        from .refinement import refinements

        return tuple(refinements(self.verdicts, self.given, self.sizes)) if self.sizes else ()

    def compare(self, name: str) -> Comparison:
        """Return what a program gives, and ours at its times and radii."""
        theirs = self.dataset[list(self.solutions[name].results)].sel(solver=name)
        for dim in list(theirs.dims):
            theirs = theirs.dropna(dim, how="all")
        given = {str(key): of.values for key, of in theirs.items()}
        ours = {
            key: self.dataset[key]
            .sel(solver=best(self.solutions, key))
            .reindex_like(theirs[key])
            .values
            for key in given
            if best(self.solutions, key)
        }
        times, radii = theirs["time"].values, theirs.get("radius", np.empty(0))
        return Comparison(times, np.asarray(radii), given, ours, self.scene)

    @cached_property
    def diagnoses(self) -> dict[str, list[Diagnosis]]:
        """What the errors of each program look like."""
        return {name: diagnose(self.compare(name)) for name in self.judged}

    @property
    def lines(self) -> list[str]:
        """The verdict on theirs, for people."""
        names, lines = UnitNames.of(self.scene.units), list[str]()
        for name in self.judged:
            judged = [row for row in self.verdicts if row.solver == name]
            lines.append(f"{name}: {self._verdict_on(judged)}")
            for _, rows in groupby(judged, lambda row: row.quantity):
                lines.append(f"{name}: {in_words(list(rows), names)}")
            lines += [
                f"{name} looks like this: {fault.words} (confidence {fault.confidence:.0%}; to be "
                f"sure: {fault.confirm})"
                for fault in self.diagnoses[name]
            ]
        return lines + [f"refinement: {row.in_words(names)}" for row in self.refinements]

    def _verdict_on(self, judged: list[Verdict]) -> str:
        """Return in words whether all that a program gives is within what is allowed."""
        beyond = dict.fromkeys(row.quantity for row in judged if not row.within)
        given = dict.fromkeys(row.quantity for row in judged)
        if not judged:
            return "nothing of it could be compared"
        if not beyond:
            return f"all {len(given)} quantities are within {self.within:.3g} of ours"
        names = ", ".join(name.replace("_", " ") for name in beyond)
        counts = f"{len(beyond)} of {len(given)} quantities"
        return f"{counts} differ from ours by more than {self.within:.3g}: {names}"

    @property
    def notes(self) -> tuple[str, ...]:
        """The verdict on the results of other programs, then the notes of our methods."""
        return (*self.lines, *super().notes)

    @property
    def summary(self) -> dict[str, Any]:
        """The summary of the run, with the verdicts and the diagnoses on results of other programs.

        There, numbers that are not finite are None, because JSON cannot express them.
        """
        rows = [_plain(row) for row in self.verdicts]
        looks = {name: [_plain(of) for of in self.diagnoses[name]] for name in self.judged}
        return super().summary | {"verdicts": rows, "diagnoses": looks}


def _plain(row: Verdict | Diagnosis) -> dict[str, object]:
    """Return a row for JSON, which has null for what is infinite or not given."""
    values = asdict(row).items()
    return {key: of if isinstance(of, str) or np.isfinite(of) else None for key, of in values}
