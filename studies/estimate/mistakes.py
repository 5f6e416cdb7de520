"""The mistakes that people often make, as one table for each kind of scene.

A row has a name, what is changed and by which values, what the difference looks like, and what the
user can do to confirm it. Of mistakes that explain the same, the first in the table is named first.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from ..crosscheck import Scene
from .compared import Comparison
from .parameter import Change, Parameter, Reading, SceneChange, Situation
from .select import COARSE_MESH, Mistake

LENGTHS = ("displacement", "profile", "indentation")
KINDS = {"lengths": LENGTHS, "pressure": ("pressure",), "normal_force": ("normal_force",)}
POWERS = tuple(1000.0**power for power in (-3, -2, -1, 1, 2, 3))
FACTORS = (1e-3, 0.03, 0.1, 0.4, 0.8, 1.25, 2.5, 10.0, 30.0, 1e3)
# relative error of the start on a clamped half-space, times R / a, by Poisson's ratio (`study
# truncation`)
TRUNCATION_ERRORS = ([0, 0.3, 0.45, 0.5], [0.94, 1.09, 1.51, 1.91])
# greatest number of wear coefficients, and of layers, of which each is considered
MAX_MATERIALS, MAX_LAYERS, MAX_RINGS = 5, 2, 24
# greatest number of rings of which each is considered alone, and factor on a forgotten coefficient
MAX_SINGLE_RINGS, FORGOTTEN = 12, 1e-3
# greatest relative difference of a fitted factor to a well-known one whose name it is given
MAX_FACTOR_DIFFERENCE = 0.01
# spacing of the nodes for mistakes in layers, whose size is known roughly
COARSE = 0.7


# ---- kinds of parameters --------------------------------------------------------------------


def factor(change: Change, starts: tuple[float, ...] = FACTORS) -> Parameter:
    """Return a positive factor that is fitted."""
    return Parameter("factor", change, reach=math.log(1e9), starts=starts)


def choice(change: Change, *values: float) -> Parameter:
    """Return a number that has one of several values."""
    return Parameter("choice", change, 0.0, math.inf, logarithmic=False, values=values)


def scale(
    name: str,
    change: Callable[[Scene, float], Scene],
    reach: float = math.log(11),
    starts: tuple[float, ...] = (0.45, 2.2),
    spacing: float = 0.4,
) -> Parameter:
    """Return a factor on numbers of the scene that is fitted."""
    return Parameter(name, SceneChange(change), reach=reach, starts=starts, spacing=spacing)


def set_reading(name: str) -> Change:
    """Return a change that sets one field of the reading."""
    return lambda scene, reading, value: (scene, reading.changed(name, value))


def columns(*names: str) -> Change:
    """Return a change that multiplies columns of a table."""
    return lambda scene, reading, value: (scene, reading.multiplied(value, *names))


# parts of the whole force that programs report
PARTS_OF_CIRCLE = {
    1 / 180: "on a wedge of 2 degrees, 1/180 of the whole, as in CalculiX",
    1 / 360: "on a wedge of 1 degree, 1/360 of the whole",
    1 / (2 * math.pi): "per radian, 1/(2 pi) of the whole",
}


# ---- changes of a scene ---------------------------------------------------------------------


def with_force(scene: Scene, size: float) -> Scene:
    """Return a scene with its load multiplied by a factor."""
    for key in ("normal_force", "mean_pressure"):
        value = getattr(scene.load_, key)
        if isinstance(value, float | int):
            return scene.changed({f"load.{key}": value * size})
        if value is not None:
            return scene.changed({f"load.{key}": _multiplied(value.model_dump(), size)})
    return scene


def _multiplied(curve: dict[str, list[float]], size: float) -> dict[str, list[float]]:
    return curve | {"values": [size * each for each in curve["values"]]}


def with_modulus(scene: Scene, size: float) -> Scene:
    """Return a scene with the modulus of the half-space and of all layers multiplied."""
    if not scene.half_space.layers:
        modulus = scene.half_space.own_modulus * size
        return scene.changed({"half_space.plane_strain_modulus": modulus})
    materials = layer_tables(scene)
    for each in materials:
        each["youngs_modulus"] = each.get("youngs_modulus", 1.0) * size
    return with_layers(scene, materials)


def with_radius(scene: Scene, size: float) -> Scene:
    """Return a scene with the radius of the punch and its rings multiplied."""
    punch = scene.punch
    changes: dict[str, Any] = {"punch.radius": punch.radius * size}
    if punch.ring_edges is not None:
        changes["punch.ring_edges"] = [size * edge for edge in punch.ring_edges]
    if punch.inner_radius:
        changes["punch.inner_radius"] = punch.inner_radius * size
    if punch.table:
        table = punch.table.model_dump()
        table["radii"] = [size * each for each in table["radii"]]
        changes["punch.wear_coefficient"] = table
    return scene.changed(changes)


def ring_wear(scene: Scene) -> list[float]:
    """Return the wear coefficient of each ring of a scene."""
    rings = len(scene.problem.ring_edges) - 1
    return [float(each) for each in np.resize(scene.punch.coefficients, rings)]


def with_wear(scene: Scene, changed: Callable[[float], float]) -> Scene:
    """Return a scene with a function of each wear coefficient in place of it."""
    wear = [changed(each) for each in ring_wear(scene)]
    return scene.changed({"punch.wear_coefficients": wear})


def with_wear_of(others: Mapping[float, float], scene: Scene, _: float) -> Scene:
    """Return a scene with other wear coefficients in place of some."""
    return with_wear(scene, lambda each: others.get(each, each))


def with_wear_times(coefficient: float, scene: Scene, size: float) -> Scene:
    """Return a scene with one of its wear coefficients multiplied."""
    return with_wear(scene, lambda each: each * size if each == coefficient else each)


def with_step(sign: float, scene: Scene, reading: Reading, length: float) -> Situation:
    """Return a reading with time steps of first order."""
    return scene, reading._replace(step=sign * length)


def with_edges(scene: Scene, size: float) -> Scene:
    """Return a scene with all edges between rings multiplied, and the rim as it is."""
    edges = scene.problem.ring_edges[1:] * scene.punch.radius
    edges[:-1] *= size
    keys = {"punch.ring_edges": edges.tolist(), "punch.wear_coefficients": ring_wear(scene)}
    return scene.changed(keys)


def layer_tables(scene: Scene) -> list[dict[str, float]]:
    """Return the tables of the layers of a scene and, last, of the base."""
    ground = scene.half_space
    below = {"thickness": 1.0, "poisson_ratio": ground.poisson_ratio}
    if not ground.rigid:
        below["youngs_modulus"] = ground.youngs_modulus or (
            (ground.plane_strain_modulus or 0.0) * (1 - ground.poisson_ratio**2)
        )
    return [*(layer.model_dump() for layer in ground.layers), below]


def with_layers(scene: Scene, materials: list[dict[str, float]]) -> Scene:
    """Return a scene with other layers and another base: `layer_tables`."""
    *layers, base = materials
    changes: dict[str, object] = {"half_space.layers": layers}
    if not scene.half_space.rigid:
        changes["half_space.youngs_modulus"] = base["youngs_modulus"]
        changes["half_space.poisson_ratio"] = base["poisson_ratio"]
    return scene.changed(changes)


def with_material(place: int, key: str) -> Callable[[Scene, float], Scene]:
    """Return a change of one number of a layer or of the base: a factor, or Poisson's ratio."""

    def change(scene: Scene, value: float) -> Scene:
        materials = layer_tables(scene)
        materials[place][key] = value if key == "poisson_ratio" else materials[place][key] * value
        return with_layers(scene, materials)

    return change


def with_exchanged(places: tuple[int, int], keys: Sequence[str]) -> Callable[[Scene, float], Scene]:
    """Return a change that exchanges numbers of two layers."""

    def change(scene: Scene, _: float) -> Scene:
        materials = layer_tables(scene)
        upper, lower = (materials[place] for place in places)
        for key in keys:
            upper[key], lower[key] = lower[key], upper[key]
        return with_layers(scene, materials)

    return change


def with_layer(key: str, scene: Scene, value: float) -> Scene:
    """Return a scene with a layer of the material of the half-space, and one number multiplied.

    The thickness is that over the punch radius.
    """
    if not scene.half_space.layers:
        (base,) = layer_tables(scene)
        layer = base | {"thickness": scene.punch.radius}
        scene = with_layers(scene, [layer, base])
    return with_material(0, key)(scene, value)


def mesh_part() -> Parameter:
    """Return the part of the errors of a linear mesh that a table has, from 0 to 1."""
    change = set_reading("mesh")
    return Parameter("mesh", change, 0.5, 1.0, logarithmic=False, scale=0.5)


def coarse_mesh(errors: float, clamped: Change | None) -> Iterator[Mistake]:
    """Yield the errors of a mesh whose nodes are at the radii, without and with those below it.

    Parameters
    ----------
    errors : relative errors of pressures by the nodes alone
    clamped : change by which all displacements are too low, as they are if elements below the
        surface are too large; None if there is none
    """
    nodes = replace(mesh_part(), value=1.0, scale=1.0)
    rows: list[tuple[Parameter, ...]] = [(nodes,)]
    if clamped is not None:
        below = Parameter("a/R", clamped, errors, 1.0, logarithmic=False, scale=errors)
        rows.append((nodes, below))
    for parameters in rows:
        yield Mistake(
            COARSE_MESH,
            "a mesh that is too coarse: {0:.2g} times the errors of linear elements with nodes at "
            "these radii",
            "halve the element size: this error decreases; give both results with --refinement",
            parameters,
            of_mesh=True,
        )


# ---- the table ------------------------------------------------------------------------------


def mistakes(comparison: Comparison) -> Iterator[Mistake]:
    """Yield the mistakes that could be recognised in results of a scene."""
    scene, problem = comparison.scene, comparison.scene.problem
    names = {*comparison.quantities}
    later = bool((comparison.times[comparison.time_rows] > 0).any())
    several = len(comparison.time_rows) > 1
    flat = problem.full_contact and not problem.loading.varies
    steady_load = not problem.loading.varies
    by_force = problem.indentation is None
    bare = not problem.ground.layered
    written = scene.unit_names.write

    errors = dict(zip(comparison.quantities, comparison.mesh_errors(), strict=False))
    error = float(np.sqrt(np.mean(errors["pressure"] ** 2))) if errors else 0.0
    if error and not (bare and (flat or by_force)):
        yield from coarse_mesh(error, None)
    if bare and (flat or by_force):
        low = float(np.interp(problem.poisson_ratio, *TRUNCATION_ERRORS))

        # a program that prints forces but no displacements prescribes ours, as decks do: its forces
        # and pressures are then too high, as if the punch were deeper
        at_our_depth = by_force and "normal_force" in names and not names & {*LENGTHS} - {"profile"}

        def clamped(scene: Scene, reading: Reading, part: float) -> Situation:
            if at_our_depth:
                return scene, reading.multiplied(1 + part * low, "pressure", "normal_force")
            units = scene.problem.units
            compliance = -part * low / 2 * units.displacement / units.force
            return scene, reading._replace(ground_compliance=compliance)

        if error:
            yield from coarse_mesh(error, clamped)
        yield Mistake(
            "truncated half-space",
            lambda part: (
                "a half-space that is clamped at a distance R of about "
                f"{1 / part:.4g} radii: "
                + (
                    "all displacements are too low by the same length, about 1.1 a/R of the "
                    "indentation"
                    if by_force and not at_our_depth
                    else "forces are too high for the indentation, the first one by about 1.1 a/R"
                )
            ),
            "compute with a half-space twice as large: the error is halved",
            (Parameter("a/R", clamped, 0.02, math.log(20), starts=(0.005, 0.05, 0.2)),),
            of_mesh=True,
            size=lambda part: 1 / part,
        )

    # the program has another clock
    if later:
        yield Mistake(
            "units of time",
            lambda value: (
                f"another unit of time, {value:.4g} times that of the scene: the "
                f"column time is {1 / value:.4g} times ours"
            ),
            "give the unit of time of the table by --units, or in the heading of its times; a "
            "wear coefficient or a sliding speed in another unit has the same effect",
            (choice(set_reading("time_scale"), 1e3, 1e-3, 60.0, 1 / 60, 3600.0, 1 / 3600),),
        )
    if later and steady_load:
        yield Mistake(
            "wear coefficient",
            "a wear coefficient or a sliding speed of {0:.4g} times ours: time runs {0:.4g} "
            "times as fast",
            "compare k and v of the input, and their units; with all times multiplied by this "
            "factor the error disappears",
            (factor(set_reading("time_scale")),),
        )
    if several:
        last = float(comparison.times.max())
        yield Mistake(
            "late start",
            lambda start: (
                f"a history that starts too late, at about t = {written(start, 'time', 3)}"
            ),
            "subtract this from all times: the error disappears",
            (
                Parameter(
                    "start",
                    set_reading("start_time"),
                    0.1 * last,
                    math.log(10),
                    starts=tuple(last * part for part in (0.02, 0.1, 0.3, 0.6)),
                ),
            ),
        )
    if several and flat:
        longest = float(np.diff(comparison.times, prepend=0.0).max())
        for kind, sign in (("implicit", 1.0), ("explicit", -1.0)):
            yield Mistake(
                "first-order time step",
                partial(_steps_in_words, kind, written),
                "compute with half the time step: the error is halved",
                (
                    Parameter(
                        "step",
                        partial(with_step, sign),
                        longest / 20,
                        math.log(20 * last / longest),
                    ),
                ),
            )

    # the program solves another scene
    if flat and by_force:
        known = force_factors(problem.units.length)
        yield Mistake(
            "force per length",
            lambda value: (
                f"a load of {value:.4g} times ours, which multiplies all results: a "
                f"force {known[value]}"
            ),
            "compare the sum of 2 pi r p dr with the load; look up whether an axisymmetric "
            "load counts for the whole circumference",
            (choice(SceneChange(with_force), *known),),
            "normal force",
        )
        yield Mistake(
            "normal force",
            "a load of {0:.4g} times ours, which multiplies all results",
            "compare the sum of 2 pi r p dr with the load of the scene",
            (factor(SceneChange(with_force)),),
        )
    plane = 1 - problem.poisson_ratio**2
    if flat and bare and abs(problem.poisson_ratio) > 0.1:
        yield Mistake(
            "Poisson's ratio",
            "a half-space {0:.4g} times as stiff as ours: E in place of E/(1 - nu^2), or the "
            "reverse",
            "compute with a Poisson's ratio of 0: the error disappears",
            (choice(SceneChange(with_modulus), plane, 1 / plane),),
            "modulus",
        )
    if flat:
        yield Mistake(
            "modulus",
            "a half-space {0:.4g} times as stiff as ours",
            "compare the modulus of the input, and F / (2 a E*) with the first indentation",
            (factor(SceneChange(with_modulus)),),
        )
    if bare:
        yield Mistake(
            "radius for diameter",
            "a punch of {0:g} times the radius: a diameter in place of a radius, or the reverse",
            "look up the radius in the model beyond which pressures are zero",
            (choice(SceneChange(with_radius), 2.0, 0.5),),
        )
    yield from wear_mistakes(scene, later)
    if flat and by_force and bare:
        unit = min(max(2 * problem.units.length, 1e-6), 1e6)
        depth = problem.units.displacement

        def lower(scene: Scene, reading: Reading, value: float) -> Situation:
            # the depth of the body is not known, and adds a constant in proportion to the force
            offset = value * scene.problem.units.displacement / depth
            return scene, reading._replace(offset=offset)

        yield Mistake(
            "plane strain",
            lambda force, _: (
                "a strip in plane strain in place of an axisymmetric punch, under "
                f"a force per length of {force / (2 * problem.units.length):.3g} F (mean "
                f"pressure: {force * math.pi / 4:.3g} times ours)"
            ),
            "look up whether the element type is axisymmetric, and the load that of the whole "
            "circle; in plane strain the indentation grows with the logarithm of the depth of "
            "the mesh",
            (
                factor(in_plane_strain, (1.0, 4 / math.pi, unit)),
                Parameter(
                    "depth",
                    lower,
                    0.0,
                    1e3,
                    logarithmic=False,
                    scale=depth,
                    starts=(0.5 * depth, 2.0 * depth),
                ),
            ),
        )
        if problem.poisson_ratio < 0.5:
            yield Mistake(
                "layer",
                lambda thick, stiff: (
                    f"a {'soft' if stiff < 1 else 'stiff'} layer on the "
                    f"half-space, about {thick:.2g} a thick and {stiff:.2g} times as stiff as "
                    "the half-space, which the scene does not have"
                ),
                "compute with a homogeneous half-space, and compare indentation and pressures",
                tuple(
                    Parameter(
                        key,
                        SceneChange(partial(with_layer, key)),
                        value,
                        COARSE * number,
                        starts=tuple(value * math.exp(COARSE * node) for node in nodes),
                        spacing=COARSE,
                    )
                    for key, value, number, nodes in (
                        ("thickness", 0.28, 3, (-1, 1)),
                        ("youngs_modulus", 0.5, 5, (-3, -1, 2, 3)),
                    )
                ),
                size=lambda _, stiff: stiff,
            )
    if flat and not bare:
        yield from layer_mistakes(scene)
    if not problem.full_contact and bare:
        yield from shape_mistakes(scene)

    # the table has other signs, units, or factors
    for name in names:
        words = name.replace("_", " ")
        yield Mistake(
            f"sign of the {words}",
            f"an opposite sign of {words}",
            "compare the sign conventions: p is positive in compression; u, d and f are "
            "positive into the half-space",
            (choice(columns(name), -1.0),),
        )
    lengths = names & {*LENGTHS}
    kinds = {kind: {*members} & names for kind, members in KINDS.items()}
    single = [{name} for name in sorted(lengths) if len(lengths) > 1]
    for members in [*filter(None, kinds.values()), *single]:
        words = " and ".join(name.replace("_", " ") for name in sorted(members))
        verb = "are" if len(members) > 1 else "is"
        yield Mistake(
            "units",
            lambda value, members=members: (
                "other units than ours: "
                + ", ".join(f"the column {name} is {value:.4g} times ours" for name in members)
            ),
            "give the units of the table by --units, or in the headings of its columns",
            (choice(columns(*members), *POWERS),),
            "constant factor",
            words,
        )
        if members == {"normal_force"}:
            yield Mistake(
                "force on a part",
                lambda value: (
                    f"the force {PARTS_OF_CIRCLE[value]}: the column normal_force is "
                    f"{value:.4g} times ours"
                ),
                "multiply the forces of the table to those on the whole circumference",
                (choice(columns("normal_force"), *PARTS_OF_CIRCLE),),
                "constant factor",
                words,
            )
        yield Mistake(
            "constant factor",
            f"a constant factor: {words} {verb} {{0:.4g}} times ours at all times and radii",
            "compare the units and the definition of this column with those of the others",
            (factor(columns(*members)),),
            changes=words,
        )
    if len(comparison.radii) > 1:
        greatest = comparison.radii.max() / problem.units.length
        power = 1000.0 ** -round(math.log10(greatest or 1.0) / 3)
        yield Mistake(
            "units of radii",
            lambda value: (
                "radii that are "
                + {2.0: "halves of the radii", 0.5: "diameters"}.get(value, "in another unit")
                + f": the right ones are {value:.4g} times those of the table: the column "
                f"radius is {1 / value:.4g} times ours"
            ),
            "compare the greatest radius of the table with punch.radius; give --units",
            (choice(set_reading("radius_scale"), 2.0, 0.5, *[power] * (power > 1)),),
        )


def _steps_in_words(kind: str, written: Callable[..., str], length: float) -> str:
    return f"{kind} time steps of first order, about {written(length, 'time', 3)} long"


def in_plane_strain(scene: Scene, reading: Reading, value: float) -> Situation:
    """Return the scene with a load times a factor, solved in plane strain."""
    return with_force(scene, value), reading._replace(plane_strain=True)


def force_factors(radius: float) -> dict[float, str]:
    """Return descriptions of the ways to enter a load wrongly, by their factor on the force."""
    divisors = {
        2 * math.pi: "per radian, 1/(2 pi) of the whole",
        2 * math.pi * radius: "per length of the rim, 1/(2 pi a) of the whole",
        math.pi * radius**2: "per area, 1/(pi a^2) of the whole",
        2 * radius: "per length of the diameter, 1/(2a) of the whole",
        radius: "per length of the radius, 1/a of the whole",
        4.0: "of a quarter of the punch",
        2.0: "of half the punch",
    }
    multiplied = {
        value: f"{words}, but multiplied instead of divided" for value, words in divisors.items()
    }
    both = multiplied | {1 / value: words for value, words in divisors.items()}
    return {value: words for value, words in both.items() if abs(math.log(value)) > 0.06}


def wear_mistakes(scene: Scene, later: bool) -> Iterator[Mistake]:
    """Yield mistakes in the wear coefficients and edges of rings."""
    wear, edges = ring_wear(scene), scene.problem.ring_edges
    values = sorted(set(wear))
    count = len(values)
    if scene.punch.table or len(edges) > MAX_RINGS + 1 or not later or not count > 1:
        return
    for first, second in combinations(values[:MAX_MATERIALS], 2):
        yield Mistake(
            "swapped materials",
            "swapped wear coefficients of two materials"
            + (f", {first:.4g} and {second:.4g}" if count > 2 else ""),
            "look at the latest pressures: they must be greatest on rings that wear least",
            (choice(SceneChange(partial(with_wear_of, {first: second, second: first})), 1.0),),
        )
    if count > MAX_MATERIALS:
        return
    for value in values:
        # the number of a ring that alone has the material
        ring = f" (ring {wear.index(value) + 1})" if wear.count(value) == 1 else ""
        yield Mistake(
            "wear ratio",
            f"a wrong ratio of wear coefficients: that of the material with k = {value:.4g}{ring} "
            "is {0:.4g} times ours",
            "compare the wear coefficient of each material; late pressures are inverse to them",
            (scale("wear ratio", partial(with_wear_times, value)),),
        )
    yield from ring_mistakes(scene)
    if edges[0] == 0 and (edges[1:-1] * 1.24 < 1).all():
        yield Mistake(
            "ring edges",
            "edges between rings at {0:.4g} times our radii",
            "compare the radii at which late pressures jump with the ring edges of the scene",
            (scale("edges", with_edges, 0.21, (math.exp(-0.06), math.exp(0.06)), 0.06),),
        )


def ring_mistakes(scene: Scene) -> Iterator[Mistake]:
    """Yield mistakes in the wear coefficient of one ring."""
    wear = ring_wear(scene)
    remedy = "compare the wear coefficient of this ring with that of the scene"
    for number, value in enumerate(wear if len(wear) <= MAX_SINGLE_RINGS else ()):
        change = partial(with_wear_of_ring, number)
        if value:
            words = f"a wear coefficient of ring {number + 1} that is forgotten: it does not wear"
            forgotten = choice(SceneChange(change), FORGOTTEN)
            yield Mistake("forgotten ring", words, remedy, (forgotten,), size=lambda _: 0.0)
        # a ring that alone has its material has a wrong ratio of wear coefficients
        if value and wear.count(value) > 1:
            words = f"a wear coefficient of ring {number + 1} of {{0:.4g}} times ours"
            yield Mistake("wear coefficient of a ring", words, remedy, (scale("ring", change),))


def with_wear_of_ring(number: int, scene: Scene, size: float) -> Scene:
    """Return a scene with the wear coefficient of one ring multiplied."""
    wear = ring_wear(scene)
    wear[number] *= size
    return scene.changed({"punch.wear_coefficients": wear})


def layer_mistakes(scene: Scene) -> Iterator[Mistake]:
    """Yield mistakes in the layers of a scene."""
    layers, tables = scene.half_space.layers, layer_tables(scene)
    base = not scene.half_space.rigid

    def described(place: int) -> str:
        return f"layer {place + 1}" if place < len(layers) else "the base below the layers"

    def without_layers(scene: Scene, place: float) -> Scene:
        below = {key: tables[int(place)][key] for key in ("youngs_modulus", "poisson_ratio")}
        return scene.changed({"half_space": below})

    yield Mistake(
        "layers left out",
        lambda place: (
            f"a homogeneous half-space of the material of {described(int(place))}, "
            "without the layers of the scene"
        ),
        "compare the material of the model at each depth with the layers of the scene",
        (choice(SceneChange(without_layers), *range(len(layers) + base)),),
        # a layer of the modulus of the base is none
        "modulus of a layer",
        size=lambda place: tables[int(place)]["youngs_modulus"] / tables[0]["youngs_modulus"],
    )
    if len(layers) > MAX_LAYERS:
        return
    for place in range(len(layers) + base):
        ends = math.exp(-COARSE), math.exp(COARSE)
        for key in ["youngs_modulus", "thickness"][: 1 + (place < len(layers))]:
            words = key.removeprefix("youngs_")
            yield Mistake(
                f"{words} of a layer",
                f"a {words} of {described(place)} of {{0:.4g}} times ours",
                "compare Young's modulus and the thickness of each layer",
                (scale(key, with_material(place, key), math.log(5), ends, COARSE),),
            )
        ratio = tables[place]["poisson_ratio"]
        ratios = [each for each in (0.0, 0.2, 0.3, 0.4, 0.45, 0.49) if abs(each - ratio) > 0.005]
        yield Mistake(
            "Poisson's ratio of a layer",
            f"a Poisson's ratio of {described(place)} of about {{0:.2g}}",
            "compare Poisson's ratio of each layer",
            (choice(SceneChange(with_material(place, "poisson_ratio")), *ratios),),
        )
    for places in combinations(range(len(layers) + base), 2):
        for moved, what in (
            (("youngs_modulus", "poisson_ratio"), "materials"),
            (("youngs_modulus",), "moduli"),
        ):
            yield Mistake(
                "swapped layers",
                f"swapped {what} of {described(places[0])} and {described(places[1])}",
                "compare the material of the model at each depth with the layers of the scene",
                (choice(SceneChange(with_exchanged(places, moved)), 1.0),),
            )


def shape_mistakes(scene: Scene) -> Iterator[Mistake]:
    """Yield mistakes in the load, the modulus and the shape of a punch that is not flat."""
    changes = dict[str, tuple[str, Callable[[Scene, float], Scene]]]()
    if isinstance(scene.load_.normal_force, float):
        changes["normal force"] = "a load", with_force
    if scene.half_space.punch_youngs_modulus is None:
        changes["modulus"] = "a modulus of the half-space", with_modulus
    for key in ("curvature_radius", "ball_radius"):
        if hasattr(scene.punch.profile, key):
            changes["radius of curvature"] = (
                "a radius of curvature of the punch",
                partial(_with_curvature, key),
            )
    for name, (words, change) in changes.items():
        yield Mistake(
            name,
            f"{words} of {{0:.4g}} times ours",
            "compare this number of the input; compute with another one, and compare the change",
            (scale(name, change, math.log(2), (0.75, 1.33), 0.29),),
        )


def _with_curvature(key: str, scene: Scene, size: float) -> Scene:
    radius: float = getattr(scene.punch.profile, key)
    return scene.changed({f"punch.profile.{key}": radius * size})


def named(mistake: Mistake, values: tuple[float, ...], comparison: Comparison) -> str:
    """Return the name of a mistake; a factor that is well-known has a name of its own."""
    if mistake.name != "constant factor":
        return mistake.name
    plane = 1 - comparison.scene.problem.poisson_ratio**2
    labels = {1e3: "units", 1e6: "units", 2 * math.pi: "2 pi missing", plane: "Poisson's ratio"}
    for number, label in labels.items():
        nearest = min(abs(values[0] / number - 1), abs(values[0] * number - 1))
        if number != 1 and nearest < MAX_FACTOR_DIFFERENCE:
            return label
    # a factor of another mistake may come to that of a unit
    if round(math.log(abs(values[0]), 1000)) and len(mistake.changes.split(" and ")) > 1:
        return "units"
    return mistake.name


def sentence(mistake: Mistake, values: tuple[float, ...]) -> str:
    """Return what the difference looks like, with its numbers, as a noun phrase."""
    if callable(mistake.sentence):
        return mistake.sentence(*values)
    return mistake.sentence.format(*values)
