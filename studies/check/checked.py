"""The outcome of a run that also contains results of other programs, and the verdict on these."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..crosscheck import LOG
from ..crosscheck.methods.sampling.field_differences import OVER_TIME
from ..crosscheck.result.outcome import Outcome
from .causes.histories import PRINTED
from .diagnose import Comparison, Diagnosis, diagnose
from .verdict import Verdict, best, quantity_errors, verdicts

if TYPE_CHECKING:
    import pandas as pd

    from ..figures.style import Picture
    from .refinement import Refinement


@dataclass(frozen=True, eq=False, repr=False)
class CheckedOutcome(Outcome):
    """The outcome of a run that also contains results of other programs.

    Parameters
    ----------
    given : names of the other programs, or of their results
    within : relative error that is allowed
    sizes : of elements or steps, if all results are of one program, from coarse to fine, so that
        only the last one is judged; otherwise empty
    decks : radius of the half-space, in punch radii, of results of decks of this scene by
        `ringwear deck`, by the name of the results
    """

    given: tuple[str, ...]
    within: float
    sizes: tuple[float, ...]
    decks: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Errors of the other programs, by program, quantity and time."""
        return tuple(
            row
            for name in self.given
            for row in verdicts(
                self.scene, self.solutions, name, self.within, "".join(self.compared_in_fields[:1])
            )
        )

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of the programs whose results are checked."""
        return self.given

    @property
    def passes(self) -> bool:
        """Whether judged results are within the allowed error, and our methods do not disagree."""
        return all(map(self.is_within, self.judged)) and self.verdict != "disagree"

    def is_within(self, name: str) -> bool:
        """Return whether all results of a program are within the allowed error.

        Those that cannot be compared do not count, but at least one must be compared.
        """
        rows = self.verdicts_on(name)
        return bool(rows) and all(row.within for row in rows)

    def undecided_on(self, name: str) -> list[str]:
        """Return the quantities whose errors are above the allowed one, but within our estimate."""
        rows = (row for row in self.verdicts_on(name) if row.within)
        return [*dict.fromkeys(row.quantity for row in rows if abs(row.error) > self.within)]

    def verdicts_on(self, name: str) -> list[Verdict]:
        """Return the verdicts on a program."""
        return [row for row in self.verdicts if row.solver == name]

    @property
    def compared_in_fields(self) -> tuple[str, ...]:
        """Our most accurate method, then the judged programs that have fields, the last one first.

        Empty if no program has fields.
        """
        theirs = [name for name in reversed(self.judged) if self._fields_of(name)]
        ours = best(self.solutions, self._fields_of(theirs[0])[0]) if theirs else ""
        return (ours, *theirs) if ours else ()

    def _fields_of(self, name: str) -> list[str]:
        """Return the fields over time in the results of a program."""
        return [field for field in OVER_TIME if field in self.solutions[name].results]

    @property
    def errors(self) -> "pd.DataFrame":
        """The verdicts as a table: a row for each program, quantity and time."""
        import pandas as pd

        return pd.DataFrame([asdict(row) for row in self.verdicts])

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of the results that are judged: all, or the finest of a refinement."""
        return self.given[-1:] if self.sizes else self.given

    @cached_property
    def refinements(self) -> "tuple[Refinement, ...]":
        """Convergence of each quantity, if the results are a refinement."""
        from .refinement import refinements

        return tuple(refinements(self.verdicts, self.given, self.sizes)) if self.sizes else ()

    def compare(self, name: str) -> Comparison:
        """Return the results of a program, and ours at its times and radii.

        Quantities on which mistakes have no known effect are left out.
        """
        printed = [key for key in self.solutions[name].results if key in PRINTED]
        dataset = self.dataset[printed].sel(solver=name)
        for dim in list(dataset.dims):
            dataset = dataset.dropna(dim, how="all")
        theirs = {str(key): array.values for key, array in dataset.items()}
        ours = {
            key: self.dataset[key]
            .sel(solver=best(self.solutions, key))
            .reindex_like(dataset[key])
            .values
            for key in theirs
            if best(self.solutions, key)
        }
        times, radii = dataset["time"].values, dataset.get("radius", np.empty(0))
        return Comparison(times, np.asarray(radii), theirs, ours, self.scene)

    @cached_property
    def diagnoses(self) -> dict[str, list[Diagnosis]]:
        """Mistakes that may explain the errors, by program, most confident first."""
        diagnoses = {}
        for name in self.judged:
            # a mistake such as another wear coefficient is tried by solving a changed scene
            LOG.info("   check  trying mistakes that may explain the errors of %s ...", name)
            diagnoses[name] = diagnose(self.compare(name), self.decks.get(name))
        return diagnoses

    @property
    def lines(self) -> list[str]:
        """The verdict on the other programs in sentences."""
        lines = list[str]()
        for name in self.judged:
            from ..figures.scale import Scale  # imported here, because it loads matplotlib

            errors = quantity_errors(self.verdicts_on(name), Scale.of(self))
            sentences = [self.verdict_on(name), *map(str, errors), *self.mistakes_of(name)]
            lines += [f"{name}: {sentence}" for sentence in sentences]
        return lines + self.refinement_lines

    @property
    def refinement_lines(self) -> list[str]:
        """The convergence of each quantity, in sentences; empty without a refinement."""
        names = self.scene.unit_names
        return [f"refinement: {row.in_words(names)}" for row in self.refinements]

    def mistakes_of(self, name: str) -> list[str]:
        """Return the mistakes that may explain the errors of a program, the likeliest first."""
        if not self.verdicts_on(name):
            return []
        mistakes = [
            f"the error looks like {diagnosis.words} (confidence {diagnosis.confidence:.0%}). To "
            f"confirm: {diagnosis.confirm}"
            for diagnosis in self.diagnoses[name]
        ]
        if mistakes or self.is_within(name):
            return mistakes
        return ["no mistake that was tried explains the error"]

    def shows_others(self, picture: "Picture") -> bool:
        """Return whether a figure shows the results of other programs."""
        given = {name for program in self.judged for name in self.solutions[program].results}
        return picture.file == "refinement.png" or bool(given.intersection(picture.quantities))

    def verdict_on(self, name: str) -> str:
        """Return a sentence on whether all quantities of a program are within the allowed error."""
        judged = self.verdicts_on(name)
        exceeding = dict.fromkeys(row.quantity for row in judged if not row.within)
        quantities = dict.fromkeys(row.quantity for row in judged)
        if not judged:
            return "none of its results could be compared"
        if not exceeding:
            line = f"all {len(quantities)} quantities are within {self.within:.3g} of ours"
            unsure = ", ".join(each.replace("_", " ") for each in self.undecided_on(name))
            return f"{line}, or within our own error estimate: {unsure}" if unsure else line
        names = ", ".join(name.replace("_", " ") for name in exceeding)
        counts = f"{len(exceeding)} of {len(quantities)} quantities"
        return f"{counts} differ from ours by more than {self.within:.3g}: {names}"

    @property
    def about_others(self) -> tuple[str, ...]:
        """The verdict on the results of other programs, in sentences."""
        return tuple(self.lines)

    @property
    def summary(self) -> dict[str, Any]:
        """The summary of the run, with the verdict on the results of other programs in words.

        It also contains their errors and the mistakes that may explain these.

        Numbers that are not finite are None, because JSON cannot express them.
        """
        rows = [_json_row(row) for row in self.verdicts]
        looks = {name: [_json_row(row) for row in self.diagnoses[name]] for name in self.judged}
        check = {"passes": self.passes, "within": self.within, "lines": self.lines}
        return super().summary | {"check": check, "verdicts": rows, "diagnoses": looks}


def _json_row(row: Verdict | Diagnosis) -> dict[str, object]:
    """Return a row for JSON, with None for numbers that are not finite."""
    items = asdict(row).items()
    return {
        key: value if isinstance(value, str) or np.isfinite(value) else None for key, value in items
    }
