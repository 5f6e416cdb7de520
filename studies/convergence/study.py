"""Orders of convergence of every quantity of a scene, beside those of theory.

A level is a run of the scene by a discretisation that the study fixes, so that it has all
quantities that the scene has, and functions of a result that a user brings. Each is measured in its
norm by one reference run, or by a closed form. Abscissas of theory are in the table (`size`),
beside unknowns and seconds; figures may be drawn against any of them.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from ...meshes.errors import SceneError
from ..problem.problem import Problem
from ..problem.regimes import MOVING_CONTACT
from ..registry import METHODS
from ..scene.scene import Scene
from ..study.levels import SECONDS, Family, Record
from ..study.options import Options
from ..study.orders import ORDER_TOLERANCE, Sequence
from ..study.study import Study
from .axis_stresses import MOST_UNKNOWNS, QUICK_MOST_UNKNOWNS
from .cell_ways import FINER, QUICK_FINER, ways_of_cells
from .contact_kinds import KINDS
from .figures import LABELS, Curve, Panel, draw
from .flat_start import flat_families
from .measures import PRESSURE_PART, MeasuredLevels
from .own_ways import own_ways
from .runs import STAGES, Studied
from .scene_ways import ways_of_scene
from .way import Way

FLAT_PUNCH = "flat punch of one ring"
"""The group of families that have no rings."""
FIRST_COLUMNS = ("family", "setting", "size", "unknowns")
OF_CELLS = (
    "The reference has cells half as large as the finest, so that orders between the last levels "
    "look high. Cells of the face are refined, and the elements below them only beside it: degrees "
    "1 and 2 stop at what the half-space below errs by."
)
LEFT_OUT = (
    "Higher degrees of the pressure are left out, because its sign is asked for at nodes, and an "
    "edge within an element spoils them."
)
REMARKS = {MOVING_CONTACT: (OF_CELLS, LEFT_OUT)}
"""What is told besides of some kinds of contact."""


@dataclass(frozen=True)
class Drawn:
    """A family with what its figure needs to know of it."""

    family: Family
    label: str
    group: str


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Refine a scene in every way, fit the orders of all quantities, and draw them.

    Raises
    ------
    SceneError
        if a method, a mesh, an element or a function of the user's does not go with the scene
    RingwearError
        if the reference cannot be computed
    """
    quick = options.quick
    refuse_unknown_methods(options)
    with threadpool_limits(1):
        studied = Studied.of(
            scene,
            options.quantities,
            max(QUICK_FINER if quick else FINER),
            QUICK_MOST_UNKNOWNS if quick else MOST_UNKNOWNS,
        )
        drawn = list(families(studied, options))
    measured = [measure.name for measure in studied.measures]
    own = chain.from_iterable((name, f"value of {name}") for name in options.quantities)
    theory = chain.from_iterable(each.family.theory for each in drawn)
    columns = dict.fromkeys(
        [*FIRST_COLUMNS, *measured, PRESSURE_PART, *own, *theory, *STAGES.values()]
    )
    table = record.solve("convergence", [each.family for each in drawn], list(columns))
    curves = list(curves_of(studied, drawn, table, options.against))
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
    """Raise if a method that is asked for has no sequence here.

    Raises
    ------
    SceneError
        which names those that have
    """
    known = ("mdr", "bem", "fem")
    unknown = [name for name in options.methods if name not in known]
    if unknown:
        what = "is no method" if unknown[0] not in METHODS else "has no sequence of levels"
        raise SceneError(f"--methods: {unknown[0]} {what}: give some of {', '.join(known)}")


def families(studied: Studied, options: Options) -> Iterator[Drawn]:
    """Yield the families of the study, or those that the user has asked for in their place."""
    problem, quick = studied.problem, options.quick
    kind = KINDS[problem.contact]
    ways: Iterable[Way]
    if options.meshes or options.elements or options.steps:
        if options.elements and kind.refuses_elements:
            raise SceneError(kind.refuses_elements)
        ways = own_ways(problem, options)
    elif problem.full_contact:
        for family in flat_families(problem, quick):
            if wanted(options, family.name.split()[0].lower()):
                yield Drawn(family, label_of(family.name), FLAT_PUNCH)
        ways = ways_of_scene(problem, quick)
    else:
        ways = ways_of_cells(problem, quick)
    for way in ways:
        if wanted(options, way.method):
            yield Drawn(studied.family(way), way.label, way.group)


def wanted(options: Options, method: str) -> bool:
    """Return whether a method is among those that are asked for."""
    return not options.methods or method in options.methods


def label_of(family: str) -> str:
    """Return the label of the curves of a flat family: its name without how it is refined."""
    return family.split(",")[0]


def curves_of(
    studied: Studied, drawn: Iterable[Drawn], table: pd.DataFrame, against: str
) -> Iterator[Curve]:
    """Yield the errors of each quantity on the levels of each family that were solved."""
    norms = {measure.name: measure for measure in studied.measures if not measure.signed}
    for family, label, group in ((each.family, each.label, each.group) for each in drawn):
        rows = table[table.family == family.name]
        for quantity, theory in family.theory.items():
            solved = rows[rows[quantity].notna()]
            if not len(solved):
                continue
            fields = None
            if quantity in norms:
                kept = tuple(studied.solved[family.name, at] for at in solved.setting)
                fields = MeasuredLevels(norms[quantity], kept, studied.exact, studied.problem.face)
            sizes, errors = solved[["size", quantity]].to_numpy(float).T
            sequence = Sequence(family.name, quantity, theory, sizes, errors, fields)
            abscissa = solved[SECONDS if against == "seconds" else against].to_numpy(float)
            xlabel = LABELS.get(against, family.xlabel)
            yield Curve(label, group, sequence, abscissa, xlabel, against == "size")


def figures(scene: Scene, curves: list[Curve]) -> Iterator[tuple[str, str, list[Panel]]]:
    """Yield figures by the names of their files, with their titles and panels.

    The first has one quantity and a panel for each group, the others a group each and a panel for
    each quantity.
    """
    title, groups = scene.title, dict.fromkeys(curve.group for curve in curves)
    first = next((curve.sequence.quantity for curve in curves), "")
    if any(curve.sequence.quantity == "d(t)" for curve in curves) and first != "d0":
        first = "d(t)"
    shown = [
        Panel(group, [curve for curve in curves if (curve.group, curve.sequence.quantity) == key])
        for group in groups
        for key in [(group, first)]
        if group != FLAT_PUNCH
    ]
    yield "convergence", f"{first}: {title}" if first else title, [p for p in shown if p.curves]
    for group in groups:
        of_group = [curve for curve in curves if curve.group == group]
        panels = dict[str, list[Curve]]()
        for curve in of_group:
            quantity = curve.sequence.quantity
            name = f"{how(curve)}: {quantity}" if group == FLAT_PUNCH else quantity
            panels.setdefault(name, []).append(curve)
        name = "convergence_" + group.replace(",", "").replace(" ", "_")
        yield name, f"{group}: {title}", [Panel(*item) for item in panels.items()]


def how(curve: Curve) -> str:
    """Return the method of a flat family, and how it is refined: its name without the element."""
    name, _, refined = curve.sequence.name.partition(", ")
    return f"{name.split()[0]}, {refined}"


def conclude(sequences: list[Sequence], problem: Problem) -> list[str]:
    """Return what the orders say, a sentence each."""
    kind = KINDS[problem.contact]
    judged = [sequence for sequence in sequences if sequence.verdict in ("yes", "no")]
    right = [sequence for sequence in judged if sequence.verdict == "yes"]
    told = [
        f"{len(right)} of {len(judged)} orders with a theory are within {ORDER_TOLERANCE} of it, by "
        "least squares and between the last levels."
    ]
    if not judged:
        told = [f"No order is judged. {kind.no_order}"]
    told += REMARKS.get(problem.contact, ())
    told += [
        f"{sequence.name}, {sequence.quantity}: the observed order is {sequence.order:.2f}, and "
        f"{sequence.last_order:.2f} between the last levels, where theory has "
        f"{sequence.theory.order:.3g}; the finest error is {sequence.errors[-1]:.1e}."
        for sequence in judged
        if sequence.verdict == "no"
    ]
    told += list(_say_of_index(sequences))
    for quantity in dict.fromkeys(sequence.quantity for sequence in sequences):
        of_it = [each for each in sequences if each.quantity == quantity]
        best = min(of_it, key=lambda each: each.errors[-1])
        greatest = max(each.errors[-1] for each in of_it)
        others = f"; of the others, none errs by more than {greatest:.1e}" * (len(of_it) > 1)
        told.append(
            f"{quantity}: the finest level of {best.name} errs by {best.errors[-1]:.1e}{others}."
        )
    return told


def explain_d0_orders(sequences: list[Sequence], table: pd.DataFrame) -> Iterator[str]:
    """Yield why d0 on uniform meshes is of another order than theory's: its parts cancel.

    Pressures that are too smooth at the rim press in too deep, displacements that are too stiff
    too little. Both parts are of the order of theory, but their sum changes more slowly while they
    are alike.
    """
    for sequence in sequences:
        rows = table[(table.family == sequence.name) & table[PRESSURE_PART].notna()]
        if sequence.verdict != "no" or sequence.quantity != "d0" or len(rows) < 2:
            continue
        sizes, errors, by_pressures = rows[["size", "d0", PRESSURE_PART]].to_numpy(float).T
        parts = []
        for name, part in (("pressures", by_pressures), ("displacements", errors - by_pressures)):
            order = Sequence(sequence.name, name, sequence.theory, sizes, part).last_order
            parts.append(f"the {name} alone err by {part[-1]:+.1e} with the order {order:.2f}")
        yield (
            f"{sequence.name}, d0: the order differs, because its parts have opposite signs: on "
            f"the finest level {' and '.join(parts)}, between the last two levels."
        )


def _say_of_index(sequences: list[Sequence]) -> Iterator[str]:
    """Yield how often the grid convergence index bounds the true error of the finest level."""
    stated = [(each.richardson[1], each.errors[-1]) for each in sequences]
    stated = [(index, error) for index, error in stated if np.isfinite(index)]
    if stated:
        honest = sum(error <= index for index, error in stated)
        yield (
            f"The grid convergence index exceeds the true error of the finest level in {honest} of "
            f"{len(stated)} sequences; {len(sequences) - len(stated)} sequences have none, because "
            "their last three levels do not converge in one direction, or are fewer."
        )
