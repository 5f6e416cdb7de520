"""A run in words: the same lines and tables on the terminal and on the page."""

import textwrap
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...meshes.radial import Array, ring_areas
from ..crosscheck.agreement import AGREE, DISAGREE, UNDECIDED
from ..crosscheck.dataset import Result
from ..crosscheck.scope import left_out, modelled, outside
from ..problem.problem import D0
from ..problem.quantities import ANSWER, QUANTITIES, STATES
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames

Rows = list[dict[str, str]]


class Account:
    """All that is told of a run: tables of text, lines, and a verdict.

    Answers are by the first method that gives them, with their units.
    """

    def __init__(self, result: Result) -> None:
        self.result, self.scene, self.problem = result, result.scene, result.scene.problem
        self.names, self.title = (
            UnitNames.of(self.scene.units),
            self.scene.title or "Untitled scene",
        )
        self.modelled = modelled(self.scene, result.methods)
        self.left_out = left_out(self.scene, result.methods)
        self.defaults = defaults_taken(self.scene)
        self.verdict = result.verdict if result.agreement else "one method"
        timed = (name for name, solution in result.solutions.items() if solution.wear is not None)
        self.answered_by = next(timed, next(iter(result.methods)))

    def answer(self, key: str) -> Array | None:
        """Return an answer; None if no method gives it."""
        value = self.result.first_answer(key)
        return value if np.isfinite(value).all() else None

    def write(self, key: str, digits: int = 4) -> str:
        """Return an answer with its unit."""
        unit = (ANSWER | QUANTITIES)[key].unit
        return self.names.write(float(self.result.first_answer(key)), unit, digits)

    @property
    def last_time(self) -> str:
        return self.names.write(self.scene.wear.times[-1], "time", 3)

    @property
    def worn_heights(self) -> Array | None:
        """Mean height worn off each ring."""
        worn = self.answer("worn_volume")
        areas = ring_areas(self.problem.ring_edges) * self.problem.units.length**2
        return None if worn is None else worn / areas

    @property
    def answers(self) -> list[tuple[str, str, str]]:
        """What, how much, and what that means; first what most people ask for."""
        keys = (
            *("force_start", "force_end", "time_to_half_force"),
            *("contact_radius_start", "pressure_peak_start", "time_to_full_contact"),
            *("time_to_90", "time_to_99", "indentation_start", "indentation_steady"),
            *("steady_wear_rate", "steady_rms_slope", "running_in_time"),
        )
        return [
            (
                key.replace("_", " ").replace("rms", "RMS"),
                self.write(key),
                (ANSWER | QUANTITIES)[key].definition,
            )
            for key in keys
            if self.answer(key) is not None
        ]

    @property
    def brief(self) -> list[str]:
        """The answer in up to six lines, and the verdict in a sentence."""
        first = [
            (what, value, textwrap.shorten(meaning, 76, placeholder=" ..."))
            for what, value, meaning in self.answers[:6]
        ]
        return [self.title, *columns(first), self.verdict_line]

    @cached_property
    def rings(self) -> Rows:
        """What each ring carries and wears.

        Wear coefficients k, pressures p and shares of the force at the start and when steady,
        volume and mean height worn off.
        """
        units, coefficients = self.problem.units, self.problem.wear_coefficients
        columns = {"ring": [str(ring + 1) for ring in range(len(coefficients))]}

        def add(what: str, kind: str, least: Array, most: Array, typical: float = 0.0) -> None:
            unit, name = self.names.readable(typical or float(most.max()), kind)
            ends = zip(least / unit, most / unit, strict=True)
            columns[f"{what}, {name}" if name else what] = [_write_range(*pair) for pair in ends]

        edges = self.problem.ring_edges * units.length
        add("radii", "length", edges[:-1], edges[1:])
        coefficients = coefficients * units.wear_coefficient
        add("k", "wear_coefficient", coefficients, coefficients)
        least, most, force = (
            self.result.first_answer(key) for key in ("pressure_min", "pressure_max", "force_share")
        )
        for state, when in enumerate(STATES):
            if np.isfinite(least[state]).all():
                add(f"p {when}", "pressure", least[state], most[state], units.pressure / np.pi)
                columns[f"force {when}"] = [f"{100 * part:.3g} %" for part in force[state]]
        worn, heights = self.answer("worn_volume"), self.worn_heights
        if worn is not None and heights is not None:
            add("worn", "volume", worn, worn)
            add("mean height", "displacement", heights, heights)
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    @property
    def sentences(self) -> list[str]:
        """Tell how long running-in takes, and which ring wears how much."""
        told = []
        if self.answer("force_start") is not None and self.answer("force_end") is not None:
            half = self.answer("time_to_half_force")
            told.append(
                f"The force falls from {self.write('force_start', 3)} to "
                f"{self.write('force_end', 3)} by t = {self.last_time}"
                + (
                    "."
                    if half is None
                    else f", to half after {self.write('time_to_half_force', 3)}."
                )
            )
        if self.answer("time_to_full_contact") is not None:
            told.append(f"All of the face carries after {self.write('time_to_full_contact', 3)}.")
        if (ninety := self.answer("time_to_90")) is not None:
            told.append(
                f"Running-in takes {self.write('time_to_99', 3)}: by then 99 % of it is over, and "
                f"90 % after {self.write('time_to_90', 3)}."
            )
            if self.scene.wear.times[-1] < ninety:
                told.append(f"The times asked for end at {self.last_time}, before that.")
        if self.answer("steady_wear_rate") is not None:
            told.append(
                f"In the steady state every ring loses {self.write('steady_wear_rate', 3)} of "
                "height, and the profile stays as it is."
            )
        if (heights := self.worn_heights) is not None and heights.any():
            written = [self.names.write(float(height), "displacement", 3) for height in heights]
            most, least = int(heights.argmax()), int(heights.argmin())
            others = f", the most, and ring {least + 1} by {written[least]}, the least"
            told.append(
                f"By t = {self.last_time} ring {most + 1} has worn by {written[most]} on average"
                f"{others if len(heights) > 1 else ''}."
            )
        return told

    @property
    def verdict_line(self) -> str:
        anchors = self.result.anchors
        holding = sum(anchor.holds for anchor in anchors)
        line = "One method: nothing to compare it with"
        if self.result.agreement:
            line = self.result.verdict_in_words.rstrip(".")
        return f"{line}; {holding} of {len(anchors)} anchors (closed forms and balances) hold."

    @property
    def methods(self) -> Rows:
        """What each method cost, and says of its own error."""
        estimate = "own error estimate (relative, of the indentation)"
        return [
            {
                "method": name,
                "unknowns": str(solution.unknowns),
                "seconds": f"{sum(self.result.stages[name].seconds.values()):.3f}",
                estimate: ", ".join(f"{part} {of:.1e}" for part, of in solution.parts.items()),
            }
            for name, solution in self.result.solutions.items()
        ]

    @cached_property
    def agreement(self) -> Rows:
        """Each quantity by the two methods whose difference says most."""
        order = (AGREE, UNDECIDED, DISAGREE)
        rows = sorted(
            self.result.agreement, key=lambda row: (order.index(row.verdict), row.difference)
        )
        worst = {row.quantity: row for row in rows}
        return [
            {
                "quantity": name,
                "methods": ", ".join(worst[name].methods),
                "difference": f"{worst[name].difference:.1e}",
                "uncertainty": f"{worst[name].uncertainty:.1e}",
                "verdict": worst[name].verdict,
            }
            for name in QUANTITIES
            if name in worst
        ]

    @cached_property
    def anchors(self) -> Rows:
        """Each anchor by the method that is furthest off."""
        anchors = sorted(
            self.result.anchors, key=lambda anchor: (not anchor.holds, anchor.difference)
        )
        worst = {anchor.name: anchor for anchor in anchors}
        return [
            {
                "anchor": name,
                "method": anchor.method,
                "difference": f"{anchor.difference:.1e}",
                "tolerated": f"{anchor.tolerance:.1e}",
                "": "holds" if anchor.holds else "DOES NOT HOLD",
            }
            for name, anchor in worst.items()
        ]

    @property
    def comparisons(self) -> list[str]:
        """How far methods differ for every pressure at once."""
        return [
            f"As operators, {' and '.join(both.methods)} differ by {both.rings:.1e} over all "
            f"steady states and {both.history:.1e} along this history; stability "
            f"{both.stability:.2f}."
            for both in self.result.operators
        ]

    @property
    def own_errors(self) -> list[str]:
        """What methods say of themselves that is more than was asked for."""
        rtol, lines = self.scene.accuracy.rtol, list[str]()
        for name, solution in self.result.solutions.items():
            if beyond := solution.beyond(rtol):
                listed = ", ".join(f"{quantity} {error:.1e}" for quantity, error in beyond.items())
                lines.append(
                    f"{name} says of itself that it errs by more than the {rtol:.0e} asked for in: "
                    f"{listed}"
                )
        return lines

    @property
    def remarks(self) -> list[str]:
        """What else a user has to know."""
        result = self.result
        lines = beyond_the_model(self.scene) + [
            f"{anchor.method} does not hold to {anchor.name}: off by {anchor.difference:.1e}, more "
            f"than {anchor.tolerance:.1e}."
            for anchor in result.anchors
            if not anchor.holds
        ]
        undecided = sorted(
            (row for row in result.agreement if row.remark), key=lambda row: row.uncertainty
        )
        worst = {row.quantity: row for row in undecided}
        rows = [worst[name] for name in QUANTITIES if name in worst]
        for remark in dict.fromkeys(row.remark for row in worst.values()):
            listed = ", ".join(
                f"{row.quantity} ({row.when})" if row.when else row.quantity
                for row in rows
                if row.remark == remark
            )
            lines.append(f"undecided: {listed}: {remark}")
        slowest = self.answer("running_in_time")
        # contact that spreads has a time scale of its own
        if slowest is not None and self.problem.earliest and self.problem.full_contact:
            scale = self.problem.units.time / float(slowest)
            lines += outside(self.problem.earliest * scale, self.problem.distances[-1] * scale)
        return lines + [f"note: {note}" for note in result.notes]


def _write_range(least: float, most: float) -> str:
    """Return a range as text; once where both ends are the same."""
    if np.isinf(most):
        return f"{least:.4g} to infinity"
    same = abs(most - least) <= 1e-3 * abs(most)
    return f"{least:.4g}" if same else f"{least:.4g} to {most:.4g}"


def beyond_the_model(scene: Scene) -> list[str]:
    """Return warnings where the strains of a scene with units are no longer small."""
    problem, lines = scene.problem, list[str]()
    if UnitNames.of(scene.units).base is None:
        return lines
    units, fixed = problem.units, problem.indentation
    depth = D0 * units.slope * (fixed or 1.0)
    pressure = units.pressure / np.pi / units.modulus * (fixed or 1.0)
    for what, size, limit in (
        ("the indentation of the flat punch is {:.2g} of its radius", depth, 0.1),
        ("the mean pressure is {:.2g} of the plane strain modulus", pressure, 0.01),
    ):
        if size > limit:
            lines.append(
                f"warning: {what.format(size)}, more than {limit:g}: strains are not small, and "
                "linear elasticity, which all methods here take, does not hold"
            )
    return lines


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


def columns(lines: Sequence[Sequence[str]]) -> list[str]:
    """Return lines of text, their cells below each other."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    padded = (map(str.ljust, line, widths) for line in lines)
    return [f"  {'   '.join(line)}".rstrip() for line in padded]


def shorten(table: Rows, most: int) -> Rows:
    """Return the first and the last rows, if there are more than so many."""
    if len(table) <= most:
        return table
    return [*table[: most // 2], dict.fromkeys(table[0], "..."), *table[-(most // 2) :]]
