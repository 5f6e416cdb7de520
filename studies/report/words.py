"""The answer of a run in words: the same lines and tables on the terminal and on the page."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...meshes.radial import Array, ring_areas
from ..crosscheck.agreement import AGREE, DISAGREE, UNDECIDED, Agreement
from ..crosscheck.dataset import Result
from ..crosscheck.scope import outside
from ..methods.quantities import QUANTITIES, STATES
from ..problem.unit_names import UnitNames

# rings that a table shows at each end when there are more than both together
MOST_SHOWN = 8


class Line(NamedTuple):
    """One answer: what, how much, and what that means."""

    what: str
    value: str
    meaning: str


class Rows(NamedTuple):
    """A table of text: columns are to the right of their width but for the last."""

    headers: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def first_given(result: Result, key: str) -> Array:
    """An answer by the first method that gives it; NaN if none does."""
    every = [one[key] for one in result.answers.values()]
    return next((value for value in every if np.isfinite(value).any()), every[0])


def answered_by(result: Result) -> str:
    """The method whose answers are shown."""
    gives = [name for name, one in result.answers.items() if np.isfinite(one["running_in_time"])]
    return (gives or list(result.answers))[0]


def answer_lines(result: Result) -> list[Line]:
    """What the punch does, in a few lines."""
    scene, names = result.scene, UnitNames.of(result.scene.units)

    def text(key: str, kind: str) -> str:
        return names.write(float(first_given(result, key)), kind)

    lines = []
    if scene.wear.times:
        if np.isfinite(first_given(result, "running_in_time")):
            ninety, all_but_one = text("time_to_90", "time"), text("time_to_99", "time")
            meaning = "slowest relaxation time: what is left of running-in falls to 1/e in it"
            lines.append(Line("running-in time", text("running_in_time", "time"), meaning))
            meaning = (
                "until the approach d(t) of the punch, less steady wear, has made 90 % (99 %) of "
                "its way"
            )
            lines.append(Line("run in to 90 %, 99 %", f"{ninety}, {all_but_one}", meaning))
        flat = scene.problem.full_contact
        if flat or np.isfinite(first_given(result, "indentation_start")):
            meaning = "F / (2 a E*), flat punch" if flat else "of the unworn face plane"
            lines.append(
                Line("indentation at the start", text("indentation_start", "displacement"), meaning)
            )
    if scene.wear.steady and scene.problem.indentation is None:
        meaning = "depth of the foremost point of the worn punch"
        lines += [
            Line("indentation when steady", text("indentation_steady", "displacement"), meaning),
            Line(
                "steady wear rate",
                text("steady_wear_rate", "wear_rate"),
                "height lost in a time, the same on every ring",
            ),
            Line(
                "RMS slope when steady",
                text("steady_rms_slope", "slope"),
                f"of the limiting profile, {_average(result)}",
            ),
        ]
    worn = first_given(result, "worn_volume")
    if np.isfinite(worn).all() and scene.wear.times:
        last = names.write(scene.wear.times[-1], "time")
        lines.append(
            Line(
                "worn volume",
                names.write(float(worn.sum()), "volume"),
                f"of all rings, by t = {last}",
            )
        )
    return lines


def _average(result: Result) -> str:
    return {"line": "averaged over the radius", "area": "averaged over the area"}[
        result.scene.output.gradient_average
    ]


def ring_rows(result: Result, most: int = 2 * MOST_SHOWN) -> Rows:
    """What each ring carries and wears; of many rings the first and the last.

    Wear coefficients k, pressures p and shares of the force at the start and when steady, volume
    and mean height worn off.
    """
    problem, names = result.scene.problem, UnitNames.of(result.scene.units)
    units = problem.units
    count = len(problem.wear_coefficients)
    shown = range(count) if count <= most else [*range(most // 2), *range(count - most // 2, count)]
    edges = problem.ring_edges * units.length
    columns: dict[str, list[str]] = {"ring": [str(ring + 1) for ring in range(count)]}
    unit, name = names.readable(float(edges[-1]), "length")
    columns[_headed("radii", name)] = [
        f"{a / unit:.4g} to {b / unit:.4g}" for a, b in pairwise(edges)
    ]
    coefficients = problem.wear_coefficients * units.wear_coefficient
    columns[_headed("k", names.name("wear_coefficient"))] = [
        f"{value:.4g}" for value in coefficients
    ]
    least, most_pressed = first_given(result, "pressure_min"), first_given(result, "pressure_max")
    share, worn = first_given(result, "force_share"), first_given(result, "worn_volume")
    unit, name = names.readable(units.pressure / np.pi, "pressure")
    for state, when in enumerate(STATES):
        if np.isfinite(least[state]).all():
            spans = zip(least[state] / unit, most_pressed[state] / unit, strict=True)
            columns[_headed(f"p {when}", name)] = [_span(low, high) for low, high in spans]
            columns[f"force {when}"] = [f"{100 * value:.3g} %" for value in share[state]]
    if np.isfinite(worn).all():
        areas = ring_areas(problem.ring_edges) * units.length**2
        for what, kind, values in (
            ("worn", "volume", worn),
            ("mean height", "displacement", worn / areas),
        ):
            unit, name = names.readable(float(values.max()), kind)
            columns[_headed(what, name)] = [f"{value / unit:.4g}" for value in values]
    rows = list(zip(*columns.values(), strict=True))
    found = [rows[ring] for ring in shown]
    if count > most:
        found.insert(most // 2, ("...",) * len(columns))
    return Rows(tuple(columns), found)


def _headed(what: str, unit: str) -> str:
    return f"{what}, {unit}" if unit else what


def _span(low: float, high: float) -> str:
    """From the least to the greatest; once where they are the same."""
    if np.isinf(high):
        return f"{low:.4g} to infinity"
    return f"{low:.4g}" if abs(high - low) < 1e-3 * abs(high) else f"{low:.4g} to {high:.4g}"


def verdict(result: Result) -> str:
    """Whether to believe it, in one line."""
    count, held = len(result.anchors), sum(anchor.holds for anchor in result.anchors)
    of_anchors = (
        f"{held} of {count} anchors (closed forms and balances) hold"
        if count
        else "no anchor applies"
    )
    if not result.agreement:
        return f"One method: nothing to compare it with; {of_anchors}."
    return f"{result.verdict_in_words.rstrip('.')}; {of_anchors}."


def sentences(result: Result) -> list[str]:
    """How long it takes, which ring wears how much, and whether to believe it, for a reader of
    nothing else.
    """
    scene, names, problem = result.scene, UnitNames.of(result.scene.units), result.scene.problem
    said, edges = [], problem.ring_edges * problem.units.length

    def ring(number: int) -> str:
        unit, name = names.readable(float(edges[-1]), "length")
        return (
            f"ring {number + 1} ({edges[number] / unit:.3g} to "
            f"{edges[number + 1] / unit:.3g} {name}".rstrip()
            + ")"
        )

    if np.isfinite(ninety := first_given(result, "time_to_90")):
        last, done = scene.wear.times[-1], float(first_given(result, "time_to_99"))
        text = (
            f"Running-in takes {names.write(done, 'time', 3)}: by then 99 % of it is over, and 90 "
            "% after "
        )
        text += f"{names.write(float(ninety), 'time', 3)}."
        if last < ninety:
            text += f" The times asked for end at {names.write(last, 'time', 3)}, before that."
        said.append(text)
    if np.isfinite(rate := first_given(result, "steady_wear_rate")):
        when = "Then" if said else "In the steady state"
        said.append(
            f"{when} every ring loses {names.write(float(rate), 'wear_rate', 3)} of height, and "
            "the profile stays as it is."
        )
    worn = first_given(result, "worn_volume")
    if np.isfinite(worn).all() and worn.any():
        heights = worn / ring_areas(problem.ring_edges) / problem.units.length**2
        most, least, largest = int(heights.argmax()), int(heights.argmin()), int(worn.argmax())
        text = f"By t = {names.write(scene.wear.times[-1], 'time', 3)} {ring(most)} has worn by "
        text += f"{names.write(float(heights[most]), 'displacement', 3)} on average"
        if most != least:
            text += (
                f", the most, and {ring(least)} by "
                f"{names.write(float(heights[least]), 'displacement', 3)}, the least"
            )
        said.append(
            f"{text}; {100 * worn[largest] / worn.sum():.0f} % of the worn volume is of "
            f"{ring(largest)}."
        )
    if result.agreement:
        worst = max(result.agreement, key=lambda row: row.difference)
        within = "within" if worst.difference <= worst.uncertainty else "more than"
        said.append(
            f"{len(result.solutions)} methods differ by at most {worst.difference:.0e} of the "
            f"value ({worst.quantity}), "
            f"{within} the {worst.uncertainty:.0e} that their own error estimates allow."
        )
    return said


def anchor_rows(result: Result) -> Rows:
    """Each closed form or balance once, by the method that is furthest off."""
    rows = []
    for name in dict.fromkeys(anchor.name for anchor in result.anchors):
        own = [anchor for anchor in result.anchors if anchor.name == name]
        worst = max(
            own,
            key=lambda anchor: (
                anchor.difference / anchor.tolerance if anchor.tolerance else anchor.difference
            ),
        )
        holds = "holds" if worst.holds else "DOES NOT HOLD"
        rows.append(
            (name, worst.method, f"{worst.difference:.1e}", f"{worst.tolerance:.1e}", holds)
        )
    return Rows(("anchor", "method", "difference", "tolerated", ""), rows)


def method_rows(result: Result) -> Rows:
    """What each method cost, and what it says of its own error."""
    rows = []
    for name, solution in result.solutions.items():
        seconds = sum(result.stages[name].seconds.values())
        parts = ", ".join(f"{part} {value:.1e}" for part, value in solution.parts.items())
        rows.append((name, str(solution.unknowns), f"{seconds:.3f}", parts))
    return Rows(
        ("method", "unknowns", "seconds", "own error estimate (relative, of the indentation)"), rows
    )


def agreement_rows(result: Result) -> Rows:
    """Each quantity once, by the two methods whose difference says most."""
    order = {DISAGREE: 2, UNDECIDED: 1, AGREE: 0}

    def severity(row: Agreement) -> tuple[int, float]:
        return order[row.verdict], row.difference

    rows = []
    for quantity in (name for name in QUANTITIES if name in result.quantities):
        row = max((row for row in result.agreement if row.quantity == quantity), key=severity)
        pair = f"{row.methods[0]}, {row.methods[1]}"
        rows.append(
            (quantity, pair, f"{row.difference:.1e}", f"{row.uncertainty:.1e}", row.verdict)
        )
    return Rows(("quantity", "methods", "difference", "uncertainty", "verdict"), rows)


def remarks(result: Result) -> list[str]:
    """What else bears on the accuracy, a line each."""
    lines = [
        f"As operators, {both.methods[0]} and {both.methods[1]} differ by {both.rings:.1e} over "
        "all steady states and "
        f"{both.history:.1e} along this history; stability {both.stability:.2f}, residual "
        f"{both.residual:.1e}."
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
    lines += undecided(result)
    if (
        np.isfinite(slowest := first_given(result, "running_in_time"))
        and result.scene.problem.earliest
    ):
        times = result.scene.problem.times * result.scene.problem.units.time / float(slowest)
        lines += outside(float(times[times > 0][0]), float(times[-1]))
    return lines + [f"note: {note}" for note in result.notes]


def undecided(result: Result) -> list[str]:
    """Return a line for each quantity that is undecided, by the two methods that are the least
    certain of it.
    """
    lines = []
    for quantity in dict.fromkeys(row.quantity for row in result.agreement if row.remark):
        rows = [row for row in result.agreement if row.quantity == quantity and row.remark]
        worst = max(rows, key=lambda row: row.uncertainty)
        pairs = f" (and {len(rows) - 1} other pairs)" if len(rows) > 1 else ""
        between = f"{worst.methods[0]} and {worst.methods[1]}{pairs}"
        lines.append(f"{quantity} is undecided between {between}: {worst.remark}")
    return lines


def defaults_taken(result: Result) -> list[str]:
    """Keys whose defaults bear on the numbers and that the scene leaves out."""
    scene, lines = result.scene, []
    if "poisson_ratio" not in scene.half_space.model_fields_set:
        lines.append(
            f"half_space.poisson_ratio is not given: {scene.half_space.poisson_ratio} is taken"
        )
    if "sliding_speed" not in scene.load_.model_fields_set:
        lines.append(
            f"load.sliding_speed is not given: {scene.load_.sliding_speed:g} is taken, so that "
            "times are sliding distances"
        )
    return lines
