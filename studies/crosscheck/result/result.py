"""The result of a run, in the scene's units.

Its numbers are an xarray Dataset (written as netCDF-4) and a summary (written as JSON).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....meshes.errors import RingwearError, SceneError
from ....meshes.radial import Array
from ...tables.writing import as_json
from ..anchors.anchor import Anchor
from ..methods.base import Method, Solution
from ..methods.inside.interior import Interior, has_inside, interior
from ..methods.sampling.field_differences import (
    IN_STEADY_STATE,
    OVER_TIME,
    FieldComparison,
    compare_fields,
)
from ..methods.sampling.sampler import Sampler
from ..problem.quantities import error_name
from ..problem.suggestions import AnswersGuesses, did_you_mean
from ..problem.unit_names import number_of
from ..problem.written import shown
from ..progress import Stages
from ..scene.scene import Scene
from ..verdict.agreement import AGREE, DISAGREE, UNDECIDED, Agreement, by_quantity
from ..verdict.promise import LeftOut, allowed_error, in_words, share
from ..versions import package_versions
from .output.files import RUN_FILES, write_numbers
from .output.folder import output_folder
from .output.table import Table
from .scope import beyond_the_model, left_out, modelled, outside
from .table import by_method, in_units, report
from .words import Account

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from ...figures.catalogue import Picture
    from .judgement import Judged
    from .load import Summary

# relative difference of two times below which they are the same
SAME_TIME = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Result(AnswersGuesses):
    """All results of a run.

    `dataset` (xarray, in the scene's units), `answers` by method, `verdict`, `error(name)`,
    `warnings`, `remarks`, `agreement`, `anchors`, `summary`, `plots`, `plot(kind)` and
    `save(folder)`.

    Parameters
    ----------
    scene : the scene that was solved
    methods : the methods by their names
    table : all results over solver, time, radius, ring and mode, in the scene's units
    answers : the numbers of the answer and their relative error estimates `<name>_error`, by method
    agreement : the verdicts on every pair of methods and every quantity
    judgement : verdict, anchors, and what is left out of the promise
    notes : notes of the methods; a note that several methods give appears once
    solutions : non-dimensional solutions by method; none in results that were read from a folder
    stages : the seconds of each stage, by method; none either
    of_others : names of other programs whose results are in the dataset as well
    about_others : the judgement on the results of other programs, in sentences
    compared_in_fields : methods that compute the same fields: the reference, the one that is drawn,
        and the others
    begun_inside : returns the fields inside the half-space that were begun with the solution
    saved : the content of `summary.json`, if the results were read from a folder
    """

    scene: Scene
    methods: Mapping[str, Method]
    table: Table
    answers: Mapping[str, Mapping[str, Array]]
    agreement: tuple[Agreement, ...]
    judgement: "Judged | Summary"
    notes: tuple[str, ...]
    solutions: Mapping[str, Solution] = field(default_factory=dict)
    stages: Mapping[str, Stages] = field(default_factory=dict)
    of_others: tuple[str, ...] = ()
    about_others: tuple[str, ...] = ()
    compared_in_fields: tuple[str, ...] = ()
    begun_inside: Callable[[], Interior | None] | None = None
    saved: dict[str, Any] | None = None

    @property
    def dataset(self) -> "xarray.Dataset":
        """All results over solver, time, radius, ring and mode, in the scene's units."""
        return self.table.dataset

    @property
    def verdict(self) -> str:
        """``"agree"``, ``"disagree"`` or ``"undecided"``: the worst verdict on what is promised.

        An anchor that does not hold makes it `disagree`. A missing anchor makes `agree`
        `undecided`.
        """
        return self.judgement.verdict

    @property
    def anchors(self) -> tuple[Anchor, ...]:
        """Closed forms and conservation laws that the report of each method is checked against."""
        return self.judgement.anchors

    @property
    def left_out_of_promise(self) -> tuple[LeftOut, ...]:
        """Quantities that cannot be promised, with the times and the reason."""
        return self.judgement.left_out_of_promise

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What to know before the numbers are used.

        The model is not valid, or the times miss the running-in, or the files of the results could
        not be checked. `notes` are those of the methods.
        """
        problem = self.scene.problem
        slowest = float(self.first("running_in_time")) / problem.units.time
        return (*beyond_the_model(self.scene), *outside(problem, slowest))

    @property
    def quantities(self) -> dict[str, str]:
        """The verdict on each quantity, over all pairs of methods."""
        return {name: row.verdict for name, row in by_quantity(self.agreement).items()}

    @property
    def verdict_in_words(self) -> str:
        """The verdict in a sentence, with quantities left out and the number that agree."""
        if not self.agreement:
            return self._verdict_without_comparison
        verdicts, scene = list(self.quantities.values()), self.scene
        agreeing = f"{share(verdicts.count(AGREE), len(verdicts))} quantities"
        if self.verdict == AGREE:
            left_out = in_words(self.left_out_of_promise, scene.wear.times, scene.unit_names)
            return f"The methods agree in {agreeing}. {left_out}".rstrip()
        counts = [
            f"{verdicts.count(word)} {word}" for word in (UNDECIDED, DISAGREE) if word in verdicts
        ]
        first = {UNDECIDED: "Not all is decided", DISAGREE: "THE METHODS DISAGREE"}[self.verdict]
        sentence = f"{first}: {', '.join([f'{agreeing} agree', *counts])}."
        if alone := [row.methods[0] for row in self.agreement if len(row.methods) == 1]:
            sentence += f" Nothing checks the {len(alone)} that {alone[0]} alone computes."
        return sentence

    @property
    def _verdict_without_comparison(self) -> str:
        """The verdict in a sentence, if no two methods are compared."""
        if self.verdict == DISAGREE:
            return "AN ANCHOR DOES NOT HOLD, and no two methods are compared."
        ours = [name for name in self.coordinates["solver"] if name not in self.of_others]
        if len(ours) == 1:
            return (
                "One method alone is undecided: there is nothing to compare it with. Give two, "
                "such as mdr and bem."
            )
        return "Nothing is decided: no two methods compute the same quantity."

    @property
    def short_of(self) -> dict[str, float]:
        """Error estimates of the indentation that are larger than is allowed, by method.

        The stated error also contains the error by which cells represent the face, which the
        difference to a coarser solution does not. If edges of the contact move, both may be twice
        as large as `rtol`, as in the verdict.
        """
        allowed = allowed_error(self.scene.problem)
        short = {}
        for name, solution in self.solutions.items():
            error = solution.error_estimate
            if "indentation" in solution.errors:
                error = max(error, solution.greatest_error("indentation"))
            if error > allowed:
                short[name] = error
        return short

    def gives(self, *quantities: str) -> bool:
        """Return whether some method computes all of these quantities."""
        return bool(set.intersection(*(set(self.by_method(name)) for name in quantities)))

    @property
    def has_inside(self) -> bool:
        """Whether fields inside the half-space are wanted, and finite elements have them."""
        return "fem" in self.solutions and has_inside(self.scene, self.solutions["fem"])

    def inside(self) -> Interior:
        """Compute displacements and stresses inside the half-space, once.

        This takes as long as the contact problem.
        """
        return self._inside

    @cached_property
    def _inside(self) -> Interior:
        begun = self.begun_inside and self.begun_inside()
        return begun or interior(self.scene, self.solutions["fem"])

    @cached_property
    def coordinates(self) -> dict[str, Array]:
        """Times, radii and rings, by their names in the dataset."""
        return {name: array.values for name, array in self.table.coords.items()}

    def reported(self, method: str) -> dict[str, Array]:
        """Return the quantities of a method and the coordinates, by their names in the dataset."""
        return report(self.table, method)

    def by_method(self, quantity: str, times: Any = ...) -> dict[str, Array]:
        """Return a quantity by the name of each method that computes it, at all or some times."""
        return by_method(self.table, quantity, times)

    @cached_property
    def field_comparisons(self) -> tuple[FieldComparison, ...]:
        """Differences of other methods from the reference in fields; the drawn one comes first."""
        if not self.compared_in_fields:
            return ()
        problem, (first, *others) = self.scene.problem, self.compared_in_fields
        reports = (self.reported(name) for name in others)
        compared = (
            compare_fields(problem, (first, name), self.reported(first), report)
            for name, report in zip(others, reports, strict=True)
        )
        return tuple(comparison for comparison in compared if comparison.fields)

    def first(self, quantity: str) -> Array:
        """Return a quantity by the first method that computes it; NaN if none does."""
        return next(iter(self.by_method(quantity).values()), np.asarray(np.nan))

    @cached_property
    def between(self) -> tuple[str, dict[str, Array]]:
        """The first method with values between the times of the scene, and these values.

        The values are quantities by name, in the scene's units. If no method has such values, the
        name is empty, and the values are the report of the first method that computes profiles.
        """
        problem = self.scene.problem
        later = problem.times[problem.distances > 0]
        for name, solution in self.solutions.items():
            wear, evolution = solution.wear, solution.evolution
            if problem.march != "modal" or not len(later):
                continue
            if wear is not None:
                # times that are dense enough on a linear and on a logarithmic axis
                times = np.linspace(later[0] ** 0.25, later[-1] ** 0.25, 200) ** 4
                history, compliance = wear.modal(np.append(0.0, times)), wear.compliance
            elif evolution is not None:
                # leave out times before the first one of the scene, except the start
                times, compliance = evolution.times, evolution.punch.compliance
                history = evolution.at(times[(times == 0) | (times >= later[0])])
            else:
                continue
            values = Sampler(problem, compliance.space, compliance).history(history)
            time = {"time": values["time"] * problem.units.time}
            return name, self.reported(name) | in_units(problem, values) | time

        first = next(iter(self.by_method("profile")), self.coordinates["solver"][0])
        return "", self.reported(first)

    def error(self, quantity: str) -> float:
        """Return the greatest relative error estimate of a quantity, over methods and times.

        Raises
        ------
        SceneError
            if no method has an error estimate of it
        """
        variables = self.table.data_vars
        estimates = variables.get(error_name(str(quantity)))
        if estimates is None:
            with_estimate = [name for name in variables if error_name(name) in variables]
            otherwise = f"give one of those in dataset: {', '.join(with_estimate)}"
            hint = did_you_mean(quantity, with_estimate, otherwise)
            raise SceneError(f"there is no error estimate of {shown(quantity)}{hint}")
        # NaN where a method has no value
        return float(np.fmax.reduce(estimates.values, axis=None))

    @property
    def summary(self) -> dict[str, Any]:
        """The content of `summary.json`: verdict, cost, error estimates, scope and notes."""
        return _summary(self) if self.saved is None else self.saved

    def __repr__(self) -> str:
        """Return the answer in a few lines, the verdict, and warnings."""
        return "\n".join(self._account.brief)

    def _repr_html_(self) -> str:
        """Return the answer, the verdict and one figure as HTML, for notebooks."""
        text = f"<pre>{escape(repr(self))}</pre>"
        if not self._pictures:
            return text
        from ...figures.style import html_of

        return text + html_of(self.plot())

    @property
    def _pictures(self) -> "Sequence[Picture]":
        """The figures that can be drawn from the results."""
        from ...figures.catalogue import PICTURES

        return [picture for picture in PICTURES if picture.drawn_for(self)]

    @property
    def plots(self) -> tuple[str, ...]:
        """The figures that `plot` can draw of these results."""
        return tuple(picture.name for picture in self._pictures)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the command prints below the verdict.

        These are warnings, anchors that do not hold, disagreements, and what is undecided, with
        reasons and remedies; errors above `rtol`; and notes.
        """
        return tuple(self._account.remarks)

    @property
    def _account(self) -> Account:
        """All texts about the results."""
        return Account(self)

    def __getitem__(self, quantity: str) -> "xarray.DataArray":
        """Return a quantity or a coordinate of `dataset`.

        Raises
        ------
        SceneError
            if there is none of that name; the message suggests the nearest name
        """
        if quantity not in self.dataset.variables:
            names = [str(name) for name in self.dataset.variables]
            hint = did_you_mean(quantity, names, f"give one of {', '.join(names)}")
            raise SceneError(f"no {shown(quantity)} in these results{hint}")
        return self.dataset[quantity]

    def plot(self, kind: str = "", time: float | str | None = None) -> "Figure":
        """Draw a figure, which notebooks show; ``.savefig("figure.pdf")`` writes it.

        Parameters
        ----------
        kind : ``"profiles_and_pressures"``, ``"history"``, ``"contact"``, ``"steady_state"``,
            ``"difference"``, ``"stress"`` or ``"mesh"``; by default the first of these that can be
            drawn. Or a field at one time: ``"profile"``, ``"pressure"`` or ``"displacement"``
        time : of a field: one of the times of the results, a number or a text such as ``"100 h"``;
            by default the last

        Raises
        ------
        SceneError
            if the results have no such figure or time; the message lists the available ones
        """
        from ...figures.catalogue import picture_of, picture_of_field

        if kind in OVER_TIME:
            picture = picture_of_field(kind, self._number_of_time(time))
            if not picture.drawn_for(self):
                raise SceneError(f"no {kind} in these results: add it to output.quantities")
            return picture.figure(self)
        if time is not None:
            raise SceneError(f"time is that of a field: give one of {', '.join(OVER_TIME)}")
        return picture_of(self._pictures, kind).figure(self)

    def _number_of_time(self, time: float | str | None) -> int:
        """Return the number of a time of the results; without a time, that of the last."""
        times, names = self.coordinates["time"], self.scene.unit_names
        if time is None:
            return len(times) - 1
        wanted = number_of(time, "time", "time", names) if isinstance(time, str) else time
        nearest = int(np.abs(times - wanted).argmin())
        if not abs(times[nearest] - wanted) <= SAME_TIME * abs(wanted):
            near = names.write(float(times[nearest]), "time")
            raise SceneError(f"time = {shown(time)}: no results then; the nearest are at {near}")
        return nearest

    def save(self, folder: str | Path) -> list[str]:
        """Write the files of ``ringwear run --out folder``; return their names.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or contains other files with these names
        RingwearError
            if a figure cannot be drawn
        """
        from ...figures.catalogue import PICTURES
        from ...report.page import show

        files = {*RUN_FILES, *(picture.file for picture in PICTURES)}
        with output_folder(folder, "run", files) as out:
            write_numbers(self.table, self.summary, out.hidden)
            if failures := show(self, self._account, PICTURES, out.hidden, page=True):
                raise RingwearError("; ".join(failures))
        return out.written


def _summary(result: Result) -> dict[str, Any]:
    """Return a summary of a run that can be written as JSON.

    It contains the verdict, the answer, cost and error estimates of each method, the agreement, the
    anchors, the scope of the model, the warnings and the notes.
    """
    scene, rtol = result.scene, result.scene.accuracy.rtol
    methods = {
        name: {
            "seconds": {
                stage: round(seconds, 6) for stage, seconds in result.stages[name].seconds.items()
            },
            "unknowns": solution.unknowns,
            "settings": solution.settings,
            "rtol_asked": rtol,
            "error_estimate": solution.error_estimate,
            "error_estimate_parts": solution.parts,
            "beyond_rtol": solution.beyond(rtol),
        }
        for name, solution in result.solutions.items()
    }
    entries = {
        "title": scene.title,
        "units": scene.units,
        "verdict": result.verdict,
        "quantities": result.quantities,
        "answer": result.answers,
        "methods": methods,
        "agreement": [
            asdict(row)
            # infinity, which a missing error estimate counts as, is read back as a number
            | {name: min(getattr(row, name), 1e99) for name in ("difference", "uncertainty")}
            | {"agrees": row.agrees}
            for row in result.agreement
        ],
        "agrees": result.verdict == AGREE,
        "left_out_of_promise": [asdict(row) for row in result.left_out_of_promise],
        "anchors": [asdict(anchor) | {"holds": anchor.holds} for anchor in result.anchors],
        "modelled": modelled(scene, result.methods),
        "left_out": left_out(scene, result.methods),
        "warnings": result.warnings,
        "notes": result.notes,
        "versions": package_versions(),
    }
    written: dict[str, Any] = as_json(entries)
    return written


def methods_with_fields(table: Table) -> tuple[str, ...]:
    """Return methods that compute the same fields: the reference, the one drawn, and the others.

    The first method is the reference. The figure of the difference shows finite elements if they
    have the fields, else the second method.
    """
    for fields in (OVER_TIME, IN_STEADY_STATE):
        methods = {method: None for name in fields for method in by_method(table, name)}
        if len(methods) > 1:
            first, *others = (name for name in table.coords["solver"].values if name in methods)
            return str(first), *sorted(map(str, others), key=lambda name: name != "fem")
    return ()
