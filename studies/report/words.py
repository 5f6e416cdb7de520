"""The results of a run as lines and tables of text, for the terminal and for the page."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...meshes.radial import Array
from ..crosscheck.agreement import DISAGREE, by_quantity
from ..crosscheck.promise import allowed_error
from ..outcome.outcome import Outcome
from ..outcome.scope import left_out, modelled, outside
from ..problem.quantities import ANSWER, QUANTITIES, STATES
from ..problem.unit_names import UnitNames
from ..scene.scene import Scene

Rows = list[dict[str, str]]


class Account:
    """All texts about a run: tables, lines and the verdict.

    Answers are those of the first method that computes them, with their units.
    """

    def __init__(self, result: Outcome) -> None:
        self.result, self.scene = result, result.scene
        self.names = UnitNames.of(self.scene.units)
        self.title = self.scene.title or "Untitled scene"
        self.modelled = modelled(self.scene, result.methods)
        self.left_out = left_out(self.scene, result.methods)
        self.defaults = defaults_taken(self.scene)
        self.verdict = result.verdict if result.agreement else "one method"
        self.worst = list(by_quantity(result.agreement).values())
        timed = (name for name, solution in result.solutions.items() if solution.wear is not None)
        self.answered_by = next(timed, str(result.coordinates["solver"][0]))

    @property
    def answers(self) -> list[tuple[str, str, str]]:
        """Name, value with unit, and meaning of each answer; the most important ones come first."""
        keys = (
            *("force_start", "force_end", "time_to_half_force"),
            *("contact_radius_start", "pressure_peak_start", "time_to_full_contact"),
            *("time_to_90", "time_to_99", "indentation_start", "indentation_steady"),
            *("steady_wear_rate", "steady_rms_slope", "running_in_time"),
        )
        lines = []
        for key in keys:
            value, quantity = float(self.result.first(key)), (ANSWER | QUANTITIES)[key]
            if np.isfinite(value):
                name = key.replace("_", " ").replace("rms", "RMS")
                written, meaning = self.names.write(value, quantity.unit), quantity.definition
                if key == "indentation_start" and self.scene.half_space.layers:
                    # leave out F / (2 a E*), which is valid on a homogeneous half-space only
                    meaning = meaning.partition(";")[0]
                lines.append((name, written, meaning))
        return lines

    @property
    def brief(self) -> list[str]:
        """The title, up to six lines of the answer, and the verdict in a sentence."""
        return [self.title, *columns(self.answers[:6]), self.verdict_line]

    @cached_property
    def rings(self) -> Rows:
        """A row for each ring.

        The columns are wear coefficient k, pressure p and share of the force (at the start and in
        the steady state), worn volume and mean worn height.
        """
        problem, result = self.scene.problem, self.result
        units, edges = problem.units, problem.ring_edges * problem.units.length
        columns = {"ring": [str(ring + 1) for ring in range(len(edges) - 1)]}

        def add(heading: str, kind: str, least: Array, most: Array) -> None:
            # pressures at the edges of a flat punch are infinite
            greatest = float(max(ends[np.isfinite(ends)].max(initial=0) for ends in (least, most)))
            unit, name = self.names.readable(greatest, kind)
            ends = zip(least / unit, most / unit, strict=True)
            columns[f"{heading}, {name}" if name else heading] = [
                _write_range(*pair) for pair in ends
            ]

        add("radii", "length", edges[:-1], edges[1:])
        coefficients = problem.wear_coefficients * units.wear_coefficient
        add("k", "wear_coefficient", coefficients, coefficients)
        if result.by_method("pressure_min"):
            least, most = result.first("pressure_min"), result.first("pressure_max")
            for state, state_name in enumerate(STATES):
                if np.isfinite(least[state]).all():
                    add(f"p {state_name}", "pressure", least[state], most[state])
                    forces = result.first("force_share")[state]
                    columns[f"force {state_name}"] = [f"{100 * share:.3g} %" for share in forces]
        if result.by_method("worn_volume"):
            worn = result.first("worn_volume")
            heights = worn / np.pi / np.diff(edges**2)
            add("worn", "volume", worn, worn)
            add("mean height", "displacement", heights, heights)
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    @property
    def verdict_line(self) -> str:
        """The verdict on the methods, and the number of anchors that hold, in a sentence."""
        anchors = self.result.anchors
        holding = sum(anchor.holds for anchor in anchors)
        line = "One method: nothing to compare it with"
        if self.result.agreement:
            line = self.result.verdict_in_words.rstrip(".")
        return f"{line}; {holding} of {len(anchors)} anchors (closed forms and balances) hold."

    @property
    def methods(self) -> Rows:
        """Unknowns, seconds and error estimates of each method."""
        estimate = "own error estimate (relative, of the indentation)"
        return [
            {
                "method": name,
                "unknowns": str(solution.unknowns),
                "seconds": f"{sum(self.result.stages[name].seconds.values()):.3f}",
                estimate: ", ".join(
                    f"{part} {error:.1e}" for part, error in solution.parts.items()
                ),
            }
            for name, solution in self.result.solutions.items()
        ]

    @property
    def agreement(self) -> Rows:
        """The worst verdict on each quantity, over all pairs of methods."""
        return [
            {
                "quantity": row.quantity,
                "methods": ", ".join(row.methods),
                "difference": f"{row.difference:.1e}",
                "uncertainty": f"{row.uncertainty:.1e}",
                "verdict": row.verdict,
            }
            for row in self.worst
        ]

    @property
    def anchors(self) -> Rows:
        """Each anchor for the method with the largest difference."""
        anchors = sorted(
            self.result.anchors, key=lambda anchor: (not anchor.holds, anchor.difference)
        )
        return [
            {
                "anchor": anchor.name,
                "method": anchor.method,
                "difference": f"{anchor.difference:.1e}",
                "tolerated": f"{anchor.tolerance:.1e}",
                "": "holds" if anchor.holds else "DOES NOT HOLD",
            }
            for anchor in {anchor.name: anchor for anchor in anchors}.values()
        ]

    @property
    def comparisons(self) -> list[str]:
        """Sentences about the differences of methods as operators."""
        return [
            f"As operators, {' and '.join(pair.methods)} differ by {pair.rings:.1e} over all "
            f"steady states and {pair.history:.1e} along this history; stability "
            f"{pair.stability:.2f}."
            for pair in self.result.operators
        ]

    @property
    def remarks(self) -> list[str]:
        """Warnings, failed anchors, disagreements, undecided quantities, errors, and notes."""
        result, rtol = self.result, self.scene.accuracy.rtol
        allowed = 2 * allowed_error(self.scene.problem)
        lines = beyond_the_model(self.scene) + [
            f"{anchor.method} fails the anchor '{anchor.name}': the difference is "
            f"{anchor.difference:.1e}, more than {anchor.tolerance:.1e}."
            for anchor in result.anchors
            if not anchor.holds
        ]
        lines += [
            f"disagree: {row.quantity} {row.when}".rstrip()
            + f": {' and '.join(row.methods)} differ by {row.difference:.1e}; rtol and their error "
            f"estimates allow {max(row.uncertainty, allowed):.1e}"
            for row in self.worst
            if row.verdict == DISAGREE
        ]
        for remark in dict.fromkeys(row.remark for row in self.worst if row.remark):
            rows = [row for row in self.worst if row.remark == remark]
            listed = ", ".join(f"{row.quantity} {row.when}".rstrip() for row in rows)
            lines.append(f"undecided: {listed}: {remark}")
        for name, solution in result.solutions.items():
            if beyond := solution.beyond(rtol):
                listed = ", ".join(f"{quantity} {error:.1e}" for quantity, error in beyond.items())
                lines.append(f"{name} states errors above rtol = {rtol:.0e}: {listed}")
        problem = self.scene.problem
        lines += outside(problem, float(result.first("running_in_time")) / problem.units.time)
        return lines + [f"note: {note}" for note in result.notes]


def _write_range(least: float, most: float) -> str:
    """Return a range as text; a single number if both ends are equal."""
    if np.isinf(most):
        return f"{least:.4g} to infinity"
    same = abs(most - least) <= 1e-3 * abs(most)
    return f"{least:.4g}" if same else f"{least:.4g} to {most:.4g}"


def beyond_the_model(scene: Scene) -> list[str]:
    """Return a warning if the strains of a scene with units are not small."""
    problem, units = scene.problem, scene.problem.units
    strain = units.pressure / np.pi / units.modulus * (problem.indentation or 1.0)
    if UnitNames.of(scene.units).base is None or strain <= 0.01:
        return []
    return [
        f"warning: the mean pressure is {strain:.2g} of the plane strain modulus, more than 0.01: "
        "strains are not small, and linear elasticity, which all methods assume, is not valid"
    ]


def defaults_taken(scene: Scene) -> list[str]:
    """Return lines about keys that a scene leaves out and whose defaults affect the numbers."""
    lines = []
    if not (scene.half_space.rigid or "poisson_ratio" in scene.half_space.model_fields_set):
        default = scene.half_space.poisson_ratio
        lines.append(f"half_space.poisson_ratio is not given: using {default}")
    for number, layer in enumerate(scene.half_space.layers):
        if "poisson_ratio" not in layer.model_fields_set:
            key = f"half_space.layers.{number}.poisson_ratio"
            lines.append(f"{key} is not given: using {layer.poisson_ratio}")
    if "sliding_speed" not in scene.load_.model_fields_set:
        lines.append(
            f"load.sliding_speed is not given: using {scene.load_.sliding_speed:g}, so that times "
            "are sliding distances"
        )
    return lines


def columns(lines: Sequence[Sequence[str]]) -> list[str]:
    """Return lines of text with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    padded = (map(str.ljust, line, widths) for line in lines)
    return [f"  {'   '.join(line)}".rstrip() for line in padded]
