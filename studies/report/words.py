"""A run in words: the same lines and tables on the terminal and on the page."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...meshes.radial import Array, ring_areas
from ..crosscheck.agreement import AGREE, DISAGREE, UNDECIDED
from ..crosscheck.dataset import Result
from ..crosscheck.scope import left_out, modelled, outside
from ..methods.quantities import ANSWER, QUANTITIES, STATES
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames


class Rows(NamedTuple):
    """A table of text."""

    headers: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]

    def shortened(self, most: int) -> "Rows":
        """Return the first and the last rows, if there are more than so many."""
        if len(self.rows) <= most:
            return self
        gap = ("...",) * len(self.headers)
        half = most // 2
        return Rows(self.headers, [*self.rows[:half], gap, *self.rows[-half:]])


@dataclass(frozen=True)
class Account:
    """All that is told of a run.

    Parameters
    ----------
    title : str
    sentences : list of str
        The answer for a reader of nothing else.
    defaults : list of str
        What the scene leaves out and bears on the numbers.
    answers : list of (str, str, str)
        What, how much, and what that means.
    answered_by : str
        Method whose answers are shown.
    rings, methods, agreement, anchors : Rows
        What each ring carries and wears; what each method cost, and says of its own error; each
        quantity by the two methods whose difference says most; each anchor by the method that is
        furthest off.
    verdict, verdict_line : str
        In a word, and in a line.
    remarks : list of str
        What else bears on the accuracy.
    modelled, left_out
        What is computed, and what is not, with the reason.
    """

    title: str
    sentences: list[str]
    defaults: list[str]
    answers: list[tuple[str, str, str]]
    answered_by: str
    rings: Rows
    verdict: str
    verdict_line: str
    methods: Rows
    agreement: Rows
    anchors: Rows
    remarks: list[str]
    modelled: list[str]
    left_out: dict[str, str]

    @classmethod
    def of(cls, result: Result) -> "Account":
        """Put a run in words."""
        scene, numbers = result.scene, Numbers(result)
        timed = (name for name, solution in result.solutions.items() if solution.wear is not None)
        return cls(
            title=scene.title or "Untitled scene",
            sentences=[*_tell_wear(numbers), *_tell_differences(result)],
            defaults=defaults_taken(scene),
            answers=answer_lines(numbers),
            answered_by=next(timed, next(iter(result.methods))),
            rings=ring_rows(numbers),
            verdict=result.verdict if result.agreement else "one method",
            verdict_line=_verdict_line(result),
            methods=_method_rows(result),
            agreement=_agreement_rows(result),
            anchors=_anchor_rows(result),
            remarks=_remarks(result),
            modelled=modelled(scene, result.methods),
            left_out=left_out(scene, result.methods),
        )


class Numbers:
    """The answers of a run, each by the first method that gives it, as text with units."""

    def __init__(self, result: Result) -> None:
        self.result, self.scene, self.problem = result, result.scene, result.scene.problem
        self.names = UnitNames.of(self.scene.units)

    def given(self, key: str) -> Array | None:
        """Return an answer; None if no method gives it."""
        value = self.result.first_answer(key)
        return value if np.isfinite(value).all() else None

    def write(self, key: str, digits: int = 4) -> str:
        """Return an answer with its unit."""
        value = float(self.result.first_answer(key))
        return self.names.write(value, (ANSWER | QUANTITIES)[key].unit, digits)

    @property
    def last_time(self) -> str:
        return self.names.write(self.scene.wear.times[-1], "time", 3)

    @property
    def edges(self) -> Array:
        return self.problem.ring_edges * self.problem.units.length

    @property
    def worn_heights(self) -> Array | None:
        """Mean height worn off each ring."""
        worn = self.given("worn_volume")
        areas = ring_areas(self.problem.ring_edges) * self.problem.units.length**2
        return None if worn is None else worn / areas


def answer_lines(numbers: Numbers) -> list[tuple[str, str, str]]:
    """Tell what the punch does: what, how much, and what that means."""
    average = {"line": "radius", "area": "area"}[numbers.scene.output.gradient_average]
    flat = numbers.problem.full_contact
    lines = [
        (what, ", ".join(numbers.write(key) for key in keys), meaning)
        for what, keys, meaning in (
            (
                "running-in time",
                ["running_in_time"],
                "slowest relaxation time: what is left of running-in falls to 1/e in it",
            ),
            (
                "run in to 90 %, 99 %",
                ["time_to_90", "time_to_99"],
                "until the approach d(t) of the punch, less steady wear, has made 90 % (99 %) of "
                "its way",
            ),
            (
                "indentation at the start",
                ["indentation_start"],
                "F / (2 a E*), flat punch" if flat else "of the unworn face plane",
            ),
            (
                "indentation when steady",
                ["indentation_steady"],
                "depth of the foremost point of the worn punch",
            ),
            (
                "steady wear rate",
                ["steady_wear_rate"],
                "height lost in a time, the same on every ring",
            ),
            (
                "RMS slope when steady",
                ["steady_rms_slope"],
                f"of the limiting profile, averaged over the {average}",
            ),
        )
        if numbers.given(keys[0]) is not None
    ]
    if (worn := numbers.given("worn_volume")) is not None:
        volume = numbers.names.write(float(worn.sum()), "volume")
        lines.append(("worn volume", volume, f"of all rings, by t = {numbers.last_time}"))
    return lines


def ring_rows(numbers: Numbers) -> Rows:
    """Tell what each ring carries and wears.

    Wear coefficients k, pressures p and shares of the force at the start and when steady, volume
    and mean height worn off.
    """
    units, count = numbers.problem.units, len(numbers.problem.wear_coefficients)
    columns = {"ring": [str(ring + 1) for ring in range(count)]}

    def add(what: str, kind: str, least: Array, most: Array, typical: float = 0.0) -> None:
        unit, name = numbers.names.readable(typical or float(most.max()), kind)
        columns[f"{what}, {name}" if name else what] = [
            _span(*ends) for ends in zip(least / unit, most / unit, strict=True)
        ]

    add("radii", "length", numbers.edges[:-1], numbers.edges[1:])
    coefficients = numbers.problem.wear_coefficients * units.wear_coefficient
    add("k", "wear_coefficient", coefficients, coefficients)
    least, most, force = (
        numbers.result.first_answer(key) for key in ("pressure_min", "pressure_max", "force_share")
    )
    for state, when in enumerate(STATES):
        if np.isfinite(least[state]).all():
            mean_pressure = units.pressure / np.pi
            add(f"p {when}", "pressure", least[state], most[state], mean_pressure)
            columns[f"force {when}"] = [f"{100 * part:.3g} %" for part in force[state]]
    worn, heights = numbers.given("worn_volume"), numbers.worn_heights
    if worn is not None and heights is not None:
        add("worn", "volume", worn, worn)
        add("mean height", "displacement", heights, heights)
    return Rows(tuple(columns), list(zip(*columns.values(), strict=True)))


def _span(least: float, most: float) -> str:
    """Return a range as text; once where both ends are the same."""
    if np.isinf(most):
        return f"{least:.4g} to infinity"
    same = abs(most - least) <= 1e-3 * abs(most)
    return f"{least:.4g}" if same else f"{least:.4g} to {most:.4g}"


def _tell_wear(numbers: Numbers) -> list[str]:
    """Tell how long running-in takes, and which ring wears how much."""
    told = []
    if (ninety := numbers.given("time_to_90")) is not None:
        told.append(
            f"Running-in takes {numbers.write('time_to_99', 3)}: by then 99 % of it is over, and "
            f"90 % after {numbers.write('time_to_90', 3)}."
        )
        if numbers.scene.wear.times[-1] < ninety:
            told.append(f"The times asked for end at {numbers.last_time}, before that.")
    if numbers.given("steady_wear_rate") is not None:
        told.append(
            f"In the steady state every ring loses {numbers.write('steady_wear_rate', 3)} of "
            "height, and the profile stays as it is."
        )
    if (heights := numbers.worn_heights) is not None and heights.any():
        written = [numbers.names.write(float(height), "displacement", 3) for height in heights]
        most, least = int(heights.argmax()), int(heights.argmin())
        others = f", the most, and ring {least + 1} by {written[least]}, the least"
        told.append(
            f"By t = {numbers.last_time} ring {most + 1} has worn by {written[most]} on average"
            f"{others if len(heights) > 1 else ''}."
        )
    return told


def _tell_differences(result: Result) -> list[str]:
    """Tell whether to believe it."""
    if not result.agreement:
        return []
    worst = max(result.agreement, key=lambda row: row.difference)
    within = "within" if worst.difference <= worst.uncertainty else "more than"
    return [
        f"{len(result.solutions)} methods differ by at most {worst.difference:.0e} of the value "
        f"({worst.quantity}), {within} the {worst.uncertainty:.0e} that their own error estimates "
        "allow."
    ]


def _verdict_line(result: Result) -> str:
    holding = sum(anchor.holds for anchor in result.anchors)
    of_anchors = f"{holding} of {len(result.anchors)} anchors (closed forms and balances) hold"
    if not result.agreement:
        return f"One method: nothing to compare it with; {of_anchors}."
    return f"{result.verdict_in_words.rstrip('.')}; {of_anchors}."


def _anchor_rows(result: Result) -> Rows:
    rows = []
    for name in dict.fromkeys(anchor.name for anchor in result.anchors):
        worst = max(
            (anchor for anchor in result.anchors if anchor.name == name),
            key=lambda anchor: (not anchor.holds, anchor.difference),
        )
        numbers = (f"{worst.difference:.1e}", f"{worst.tolerance:.1e}")
        holds = "holds" if worst.holds else "DOES NOT HOLD"
        rows.append((name, worst.method, *numbers, holds))
    return Rows(("anchor", "method", "difference", "tolerated", ""), rows)


def _method_rows(result: Result) -> Rows:
    rows = [
        (
            name,
            str(solution.unknowns),
            f"{sum(result.stages[name].seconds.values()):.3f}",
            ", ".join(f"{part} {value:.1e}" for part, value in solution.parts.items()),
        )
        for name, solution in result.solutions.items()
    ]
    estimate = "own error estimate (relative, of the indentation)"
    return Rows(("method", "unknowns", "seconds", estimate), rows)


def _agreement_rows(result: Result) -> Rows:
    order = (AGREE, UNDECIDED, DISAGREE)
    rows = []
    for quantity in (name for name in QUANTITIES if name in result.quantities):
        row = max(
            (row for row in result.agreement if row.quantity == quantity),
            key=lambda row: (order.index(row.verdict), row.difference),
        )
        numbers = (f"{row.difference:.1e}", f"{row.uncertainty:.1e}")
        rows.append((quantity, ", ".join(row.methods), *numbers, row.verdict))
    return Rows(("quantity", "methods", "difference", "uncertainty", "verdict"), rows)


def _remarks(result: Result) -> list[str]:
    lines = [
        f"As operators, {both.methods[0]} and {both.methods[1]} differ by {both.rings:.1e} over "
        f"all steady states and {both.history:.1e} along this history; stability "
        f"{both.stability:.2f}."
        for both in result.operators
    ]
    lines += [
        f"{anchor.method} does not hold to {anchor.name}: off by {anchor.difference:.1e}, more "
        f"than {anchor.tolerance:.1e}."
        for anchor in result.anchors
        if not anchor.holds
    ]
    rtol = result.scene.accuracy.rtol
    for name, solution in result.solutions.items():
        if beyond := solution.beyond(rtol):
            listed = ", ".join(f"{quantity} {error:.1e}" for quantity, error in beyond.items())
            lines.append(
                f"{name} says of itself that it errs by more than the {rtol:.0e} asked for in: "
                f"{listed}"
            )
    undecided = [row for row in result.agreement if row.remark]
    for quantity in dict.fromkeys(row.quantity for row in undecided):
        rows = [row for row in undecided if row.quantity == quantity]
        worst = max(rows, key=lambda row: row.uncertainty)
        others = f" (and {len(rows) - 1} other pairs)" if len(rows) > 1 else ""
        lines.append(
            f"{quantity} is undecided between {' and '.join(worst.methods)}{others}: {worst.remark}"
        )
    slowest = float(result.first_answer("running_in_time"))
    if np.isfinite(slowest) and result.scene.problem.earliest:
        later = [time / slowest for time in result.scene.wear.times if time]
        lines += outside(later[0], later[-1])
    return lines + [f"note: {note}" for note in result.notes]


def defaults_taken(scene: Scene) -> list[str]:
    """Tell which keys that bear on the numbers a scene leaves out."""
    lines = []
    if "poisson_ratio" not in scene.half_space.model_fields_set:
        taken = scene.half_space.poisson_ratio
        lines.append(f"half_space.poisson_ratio is not given: {taken} is taken")
    if "sliding_speed" not in scene.load_.model_fields_set:
        lines.append(
            f"load.sliding_speed is not given: {scene.load_.sliding_speed:g} is taken, so that "
            "times are sliding distances"
        )
    return lines
