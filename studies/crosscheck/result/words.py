"""The results of a run as lines and tables of text, for the terminal and for the page."""

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ....meshes.radial import Array
from ..problem.quantities import ANSWER, QUANTITIES, STATES
from ..scene.scene import Scene
from ..verdict.agreement import DISAGREE, by_quantity
from ..verdict.promise import allowed_error, share
from .scope import Methods, left_out, modelled, omitted_methods

if TYPE_CHECKING:
    from ...figures.catalogue import Picture
    from .result import Result

Rows = list[dict[str, str]]


class Account:
    """All texts about a run: tables, lines and the verdict.

    Answers are those of the first method that computes them, with their units.

    Attributes
    ----------
    template : template of the page
    """

    template: ClassVar[str] = "run.html.j2"

    def __init__(self, result: "Result") -> None:
        self.result, self.scene = result, result.scene
        self.names = self.scene.unit_names
        self.title = self.scene.title or "Untitled scene"
        if result.of_others:
            self.title = f"{', '.join(result.of_others)} checked against {self.title}"
        self.modelled = modelled(self.scene, result.methods)
        self.left_out = left_out(self.scene, result.methods)
        self.defaults = methods_taken(self.scene, result.methods) + defaults_taken(self.scene)
        self.verdict = result.verdict
        self.worst = list(by_quantity(result.agreement).values())
        timed = (name for name, solution in result.solutions.items() if solution.wear is not None)
        self.answered_by = next(timed, str(result.coordinates["solver"][0]))

    @property
    def answers(self) -> list[tuple[str, str, str]]:
        """Name, value with unit, and meaning of each answer; the most important ones come first."""
        keys = (
            *("contact_radius_end", "worn_depth_end"),
            *("force_start", "force_end", "time_to_half_force"),
            *("contact_radius_start", "pressure_peak_start", "time_to_full_contact"),
            *("time_to_90", "time_to_99", "indentation_start", "indentation_steady"),
            *("steady_wear_rate", "steady_rms_slope", "running_in_time"),
        )
        quantities, known = ANSWER | QUANTITIES, self._known_numbers
        values = {key: float(self.result.first(key)) for key in keys if key not in known}
        values = {key: value for key, value in values.items() if np.isfinite(value)}
        written = dict[str, str]()
        # all numbers of a kind have the same unit, so that they can be compared at a glance
        for kind in {quantities[key].unit for key in values}:
            of_kind = {key: value for key, value in values.items() if quantities[key].unit == kind}
            texts = self.names.write_together(list(of_kind.values()), kind)
            written |= dict(zip(of_kind, texts, strict=True))
        problem, lines = self.scene.problem, []
        full_disc = problem.full_contact and not (problem.inner_radius or problem.ground.layered)
        for key in values:
            name = key.replace("_", " ").replace("rms", "RMS")
            meaning = quantities[key].definition
            if key == "indentation_start" and not full_disc:
                # leave out F / (2 a E*)
                meaning = meaning.partition(";")[0]
            lines.append((name, written[key], meaning))
        return lines

    @property
    def _known_numbers(self) -> set[str]:
        """Numbers of the answer that the scene itself determines."""
        problem = self.scene.problem
        determined = problem.known | {problem.prescribed}
        known = {name for name, each in ANSWER.items() if each.at and each.at[0] in determined}
        return known | {"time_to_full_contact"} if problem.full_contact else known

    @property
    def warnings(self) -> list[str]:
        """The warnings of the result, each in a line."""
        return [f"warning: {warning}" for warning in self.result.warnings]

    @property
    def brief(self) -> list[str]:
        """The title, up to six lines of the answer, the verdict in a sentence, and warnings.

        The verdict on results of other programs takes the place of the answer.
        """
        if self.result.about_others:
            verdict = f"Our own methods: {self.verdict_line}"
            return [self.title, "", *self.result.about_others, "", verdict, *self.warnings]
        return [self.title, *columns(self.answers[:6]), self.verdict_line, *self.warnings]

    def first_figures(self, pictures: Iterable["Picture"]) -> list[str]:
        """Return the files of the figures that the page shows before the answer: none for a run."""
        return []

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
        holding = share(sum(anchor.holds for anchor in anchors), len(anchors))
        anchors_hold = f"{holding} anchors (closed forms and balances) hold."
        return f"{self.result.verdict_in_words} {anchors_hold.capitalize()}"

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
    def remarks(self) -> list[str]:
        """Warnings, failed anchors, disagreements, undecided quantities, errors, and notes."""
        result, rtol = self.result, self.scene.accuracy.rtol
        allowed = 2 * allowed_error(self.scene.problem)
        lines = [*self.warnings] + [
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
        return lines + [f"note: {note}" for note in result.notes]


def _write_range(least: float, most: float) -> str:
    """Return a range as text; a single number if both ends are equal."""
    if np.isinf(most):
        return f"{least:.4g} to infinity"
    same = abs(most - least) <= 1e-3 * abs(most)
    return f"{least:.4g}" if same else f"{least:.4g} to {most:.4g}"


def methods_taken(scene: Scene, methods: Methods) -> list[str]:
    """Return a line about the default methods that cannot solve a scene; empty if all can."""
    if not (omitted := omitted_methods(scene, methods)):
        return []
    return [
        f"methods is not given: using {', '.join(methods)}, without {', '.join(omitted)} "
        "('left_out' in summary.json says why)"
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
    if scene.load_.times_are_distances:
        lines.append(
            f"load.sliding_speed is not given: using {scene.load_.sliding_speed:g}, so that times "
            "are sliding distances, and wear rates are heights per distance"
        )
    return lines


def columns(lines: Sequence[Sequence[str]]) -> list[str]:
    """Return lines of text with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    padded = (map(str.ljust, line, widths) for line in lines)
    return [f"  {'   '.join(line)}".rstrip() for line in padded]
