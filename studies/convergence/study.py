"""Compare the orders of convergence of every quantity of a scene with theory.

A level is a run of the scene with a discretisation that the study prescribes. It therefore has all
quantities of the scene, and functions of a result defined by the user work on it. The error of each
quantity is computed in its norm, against one reference run or a closed form. The table contains the
size that theory refers to (`size`), the unknowns and the seconds; figures can be drawn against each
of them.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from ..crosscheck import METHODS, Problem, Scene, SceneError
from ..study.levels import SECONDS, Family, Record
from ..study.options import Options
from ..study.orders import ORDER_TOLERANCE, Sequence
from ..study.study import Study
from .axis_stresses import MOST_UNKNOWNS, QUICK_MOST_UNKNOWNS
from .cell_ways import CELL_FACTORS, QUICK_CELL_FACTORS, ways_of_cells
from .contact_kinds import CONTACT_KINDS
from .figures import LABELS, Curve, Panel, draw
from .flat_start import flat_families
from .measures import PRESSURE_PART, MeasuredLevels
from .own_ways import own_ways
from .runs import STAGES, StudiedScene
from .scene_ways import ways_of_scene
from .way import Way

FLAT_PUNCH = "flat punch of one ring"
"""Group of the families that solve the flat punch without rings."""
FIRST_COLUMNS = ("family", "setting", "size", "unknowns")
CELLS_REMARK = (
    "The reference has cells half as large as those of the finest level, so that orders between "
    "the last levels appear too high. Only cells of the face, and elements near it, are refined: "
    "for degrees 1 and 2 the error of the half-space below them remains."
)
PRESSURE_DEGREES_REMARK = (
    "Higher degrees of the pressure are left out, because the sign of the pressure is enforced "
    "only at nodes and a contact edge inside an element makes them inaccurate."
)
REMARKS = {True: (), False: (CELLS_REMARK, PRESSURE_DEGREES_REMARK)}
"""Further conclusions, by whether the punch is in full contact."""


@dataclass(frozen=True)
class DrawnFamily:
    """A family of levels, with the label of its curves and the group of its figure."""

    family: Family
    label: str
    group: str


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Refine a scene in every way, fit the orders of all quantities, and draw the errors.

    Raises
    ------
    SceneError
        if a method, a mesh, an element or a function given by the user does not fit the scene
    RingwearError
        if the reference cannot be computed
    """
    quick = options.quick
    refuse_unknown_methods(options)
    with threadpool_limits(1):
        studied = StudiedScene.of(
            scene,
            options.quantities,
            max(QUICK_CELL_FACTORS if quick else CELL_FACTORS),
            QUICK_MOST_UNKNOWNS if quick else MOST_UNKNOWNS,
        )
        drawn_families = list(families(studied, options))
    measure_names = [measure.name for measure in studied.measures]
    user_columns = chain.from_iterable((name, f"value of {name}") for name in options.quantities)
    theory = chain.from_iterable(each.family.theory for each in drawn_families)
    columns = dict.fromkeys(
        [*FIRST_COLUMNS, *measure_names, PRESSURE_PART, *user_columns, *theory, *STAGES.values()]
    )
    table = record.solve("convergence", [each.family for each in drawn_families], list(columns))
    curves = list(curves_of(studied, drawn_families, table, options.against))
    sequences = [curve.sequence for curve in curves]
    return Study(
        "convergence",
        scene,
        table,
        orders=pd.DataFrame(sequence.summary() for sequence in sequences),
        conclusions=(
            *conclude(sequences, studied.problem),
            *explain_d0_orders(sequences, table),
            *record.conclusions,
        ),
        figures={name: draw(title, panels) for name, title, panels in figures(scene, curves)},
    )


def refuse_unknown_methods(options: Options) -> None:
    """Raise an error if the study has no sequence of levels for a chosen method.

    Raises
    ------
    SceneError
        its message names the methods that have one
    """
    available = ("mdr", "bem", "fem")
    unknown = [name for name in options.methods if name not in available]
    if unknown:
        reason = "is not a method" if unknown[0] not in METHODS else "has no sequence of levels"
        raise SceneError(f"--methods: {unknown[0]} {reason}: give some of {', '.join(available)}")


def families(studied: StudiedScene, options: Options) -> Iterator[DrawnFamily]:
    """Yield the families of the study, or the user's sequences if there are any."""
    problem, quick = studied.problem, options.quick
    kind = CONTACT_KINDS[problem.full_contact]
    ways: Iterable[Way]
    if options.meshes or options.elements or options.steps:
        if options.elements and kind.elements_refusal:
            raise SceneError(kind.elements_refusal)
        ways = own_ways(problem, options)
    elif problem.full_contact:
        for family in flat_families(problem, quick):
            if is_chosen(options, family.name.split()[0].lower()):
                yield DrawnFamily(family, label_of(family.name), FLAT_PUNCH)
        ways = ways_of_scene(problem, quick)
    else:
        ways = ways_of_cells(problem, quick)
    for way in ways:
        if is_chosen(options, way.method):
            yield DrawnFamily(studied.family(way), way.label, way.group)


def is_chosen(options: Options, method: str) -> bool:
    """Return whether a method is chosen; all methods are if the options name none."""
    return not options.methods or method in options.methods


def label_of(family: str) -> str:
    """Return the label of the curves of a flat family: the part of its name before the comma."""
    return family.split(",")[0]


def curves_of(
    studied: StudiedScene, drawn_families: Iterable[DrawnFamily], table: pd.DataFrame, against: str
) -> Iterator[Curve]:
    """Yield one curve of errors for each quantity of each family, over its solved levels."""
    norms = {measure.name: measure for measure in studied.measures if not measure.signed}
    for family, label, group in ((each.family, each.label, each.group) for each in drawn_families):
        rows = table[table.family == family.name]
        for quantity, theory in family.theory.items():
            solved_rows = rows[rows[quantity].notna()]
            if not len(solved_rows):
                continue
            fields = None
            if quantity in norms:
                levels = tuple(
                    studied.level_results[family.name, setting] for setting in solved_rows.setting
                )
                fields = MeasuredLevels(
                    norms[quantity], levels, studied.exact, studied.problem.face
                )
            sizes, errors = solved_rows[["size", quantity]].to_numpy(float).T
            sequence = Sequence(family.name, quantity, theory, sizes, errors, fields)
            abscissa = solved_rows[SECONDS if against == "seconds" else against].to_numpy(float)
            xlabel = LABELS.get(against, family.xlabel)
            yield Curve(label, group, sequence, abscissa, xlabel, against == "size")


def figures(scene: Scene, curves: list[Curve]) -> Iterator[tuple[str, str, list[Panel]]]:
    """Yield for each figure the name of its file, its title and its panels.

    The first figure shows one quantity, with one panel for each group. Each other figure shows one
    group, with one panel for each quantity.
    """
    title, groups = scene.title, dict.fromkeys(curve.group for curve in curves)
    first_quantity = next((curve.sequence.quantity for curve in curves), "")
    if any(curve.sequence.quantity == "d(t)" for curve in curves) and first_quantity != "d0":
        first_quantity = "d(t)"
    first_panels = [
        Panel(group, [curve for curve in curves if (curve.group, curve.sequence.quantity) == key])
        for group in groups
        for key in [(group, first_quantity)]
        if group != FLAT_PUNCH
    ]
    first_title = f"{first_quantity}: {title}" if first_quantity else title
    yield "convergence", first_title, [panel for panel in first_panels if panel.curves]
    for group in groups:
        group_curves = [curve for curve in curves if curve.group == group]
        panels = dict[str, list[Curve]]()
        for curve in group_curves:
            quantity = curve.sequence.quantity
            name = (
                f"{method_and_refinement(curve)}: {quantity}" if group == FLAT_PUNCH else quantity
            )
            panels.setdefault(name, []).append(curve)
        name = "convergence_" + group.replace(",", "").replace(" ", "_")
        yield name, f"{group}: {title}", [Panel(*item) for item in panels.items()]


def method_and_refinement(curve: Curve) -> str:
    """Return the method and the refinement of a flat family, such as "FEM, graded"."""
    name, _, refined = curve.sequence.name.partition(", ")
    return f"{name.split()[0]}, {refined}"


def conclude(sequences: list[Sequence], problem: Problem) -> list[str]:
    """Return sentences on the orders, the grid convergence indices and the finest errors."""
    kind = CONTACT_KINDS[problem.full_contact]
    judged = [sequence for sequence in sequences if sequence.verdict in ("yes", "no")]
    agreeing = [sequence for sequence in judged if sequence.verdict == "yes"]
    sentences = [
        f"{len(agreeing)} of {len(judged)} orders with a theory are within {ORDER_TOLERANCE} of "
        "it, by least squares and between the last levels."
    ]
    if not judged:
        sentences = [f"No order can be compared with theory. {kind.no_theory_reason}"]
    sentences += REMARKS[problem.full_contact]
    sentences += [
        f"{sequence.name}, {sequence.quantity}: the observed order is {sequence.order:.2f} "
        f"({sequence.last_order:.2f} between the last levels), but the theoretical order is "
        f"{sequence.theory.order:.3g}; the finest error is {sequence.errors[-1]:.1e}."
        for sequence in judged
        if sequence.verdict == "no"
    ]
    sentences += list(_summarise_index(sequences))
    for quantity in dict.fromkeys(sequence.quantity for sequence in sequences):
        same_quantity = [each for each in sequences if each.quantity == quantity]
        best = min(same_quantity, key=lambda each: each.errors[-1])
        greatest = max(each.errors[-1] for each in same_quantity)
        others = f", the greatest is {greatest:.1e}" * (len(same_quantity) > 1)
        sentences.append(
            f"{quantity}: the smallest error on a finest level is {best.errors[-1]:.1e} "
            f"({best.name}){others}."
        )
    return sentences


def explain_d0_orders(sequences: list[Sequence], table: pd.DataFrame) -> Iterator[str]:
    """Yield explanations why d0 on uniform meshes has another order than in theory.

    The error of d0 has two parts of opposite signs. Pressures that are too smooth at the rim
    increase the indentation, displacements that are too stiff decrease it. Each part has the
    theoretical order, but while they nearly cancel, their sum has another observed order.
    """
    for sequence in sequences:
        rows = table[(table.family == sequence.name) & table[PRESSURE_PART].notna()]
        if sequence.verdict != "no" or sequence.quantity != "d0" or len(rows) < 2:
            continue
        sizes, errors, by_pressures = rows[["size", "d0", PRESSURE_PART]].to_numpy(float).T
        parts = []
        for name, part in (("pressures", by_pressures), ("displacements", errors - by_pressures)):
            order = Sequence(sequence.name, name, sequence.theory, sizes, part).last_order
            parts.append(f"{part[-1]:+.1e} due to the {name} (order {order:.2f})")
        yield (
            f"{sequence.name}, d0: the order differs from theory because the error has two parts "
            f"of opposite signs: {' and '.join(parts)} on the finest level, with orders between "
            "the last two levels."
        )


def _summarise_index(sequences: list[Sequence]) -> Iterator[str]:
    """Yield a sentence on how often the grid convergence index bounds the finest true error."""
    indices_and_errors = [(each.richardson[1], each.errors[-1]) for each in sequences]
    indices_and_errors = [
        (index, error) for index, error in indices_and_errors if np.isfinite(index)
    ]
    if indices_and_errors:
        bounded = sum(error <= index for index, error in indices_and_errors)
        yield (
            f"The grid convergence index exceeds the true error of the finest level in {bounded} "
            f"of {len(indices_and_errors)} sequences; {len(sequences) - len(indices_and_errors)} "
            "sequences have no index, because they have fewer than three levels or their last "
            "three levels do not converge monotonically."
        )
