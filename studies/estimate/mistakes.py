"""The mistakes that people often make, as one table for each kind of scene.

A row has a name, what is changed and by which values, what the difference looks like, and what the
user can do to confirm it. Of mistakes that explain the same, the first in the table is named first.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from ..crosscheck import Scene
from .compared import Comparison
from .parameter import (
    Change,
    Parameter,
    Reading,
    SceneChange,
    Situation,
    looked_up,
    with_values,
)
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
# values at which searches for a wrong ratio of wear coefficients begin, and their reach
RATIO = (0.45, 2.2), math.log(11)
# spacing of the nodes for mistakes in layers, whose size is known roughly
COARSE = 0.7


def factor(
    change: Change | str,
    starts: tuple[float, ...] = FACTORS,
    reach: float = math.log(1e9),
    spacing: float = 0.4,
) -> Parameter:
    """Return a positive factor that is fitted."""
    return Parameter("factor", change, reach=reach, starts=starts, spacing=spacing)


def choice(change: Change | str, *values: float) -> Parameter:
    """Return a number that has one of several values."""
    return Parameter("choice", change, 0.0, math.inf, logarithmic=False, values=values)


def columns(*names: str) -> Change:
    """Return a change that multiplies columns of a table."""
    return lambda scene, reading, value: (scene, reading.multiplied(value, *names))


# parts of the whole force that programs report
PARTS_OF_CIRCLE = {
    1 / 180: "on a wedge of 2 degrees, 1/180 of the whole, as in CalculiX",
    1 / 360: "on a wedge of 1 degree, 1/360 of the whole",
    1 / (2 * math.pi): "per radian, 1/(2 pi) of the whole",
}


FORCE = tuple(
    f"load.{key}{values}" for key in ("normal_force", "mean_pressure") for values in ("", ".values")
)
SIZE = "punch.radius", "punch.ring_edges", "punch.inner_radius", "punch.wear_coefficient.radii"
"""Keys of a load, and of the radii of a punch, of which a scene has some."""


def multiplied(*keys: str) -> SceneChange:
    """Return a change that multiplies the numbers, or lists of them, that a scene has at keys."""

    def change(scene: Scene, size: float) -> Scene:
        table = scene.table()
        values = {key: looked_up(table, key) for key in keys}
        numbers = {key: each for key, each in values.items() if isinstance(each, float | list)}
        return with_values(
            scene, {key: (size * np.array(each)).tolist() for key, each in numbers.items()}
        )

    return SceneChange(change)


def replaced(values: Mapping[str, float]) -> SceneChange:
    """Return a change that gives other values to keys of a scene."""
    return SceneChange(lambda scene, _: with_values(scene, values))


def written_out(scene: Scene) -> Scene:
    """Return a scene with each radius and wear coefficient of its rings, and all of its materials.

    Mistakes change these keys.
    """
    ground, punch, changes = scene.half_space, scene.punch, dict[str, object]()
    if ground.layers:
        changes["half_space.layers"] = [layer.model_dump() for layer in ground.layers]
    if not ground.rigid:
        changes["half_space.youngs_modulus"] = ground.youngs_moduli[-1]
        changes["half_space.poisson_ratio"] = ground.poisson_ratio
    if not punch.table:
        edges = scene.problem.ring_edges[1:] * punch.radius
        changes["punch.ring_edges"] = edges.tolist()
        changes["punch.wear_coefficients"] = np.resize(punch.coefficients, len(edges)).tolist()
    return scene.changed(changes)


def with_layer(key: str, scene: Scene, value: float) -> Scene:
    """Return a scene with a layer of the material of the half-space, and one number multiplied.

    The thickness is that over the punch radius.
    """
    ground = scene.half_space
    if not ground.layers:
        layer = {
            "thickness": scene.punch.radius,
            "youngs_modulus": ground.youngs_modulus,
            "poisson_ratio": ground.poisson_ratio,
        }
        scene = scene.changed({"half_space.layers": [layer]})
    return multiplied(f"half_space.layers[0].{key}").change(scene, value)


def mesh_part() -> Parameter:
    """Return the part of the errors of a linear mesh that a table has, from 0 to 1."""
    return Parameter("mesh", "mesh", 0.5, 1.0, logarithmic=False, scale=0.5)


def coarse_mesh(errors: float, clamped: Change | None) -> Mistake:
    """Return the errors of a mesh whose nodes are at the radii, with those of the mesh below it.

    Parameters
    ----------
    errors : relative errors of pressures by the nodes alone
    clamped : change by which all displacements are too low, as they are if elements below the
        surface are too large; None if there is none
    """
    parameters = [replace(mesh_part(), value=1.0, scale=1.0)]
    if clamped is not None:
        parameters.append(Parameter("a/R", clamped, errors, 1.0, logarithmic=False, scale=errors))
    return Mistake(
        COARSE_MESH,
        "a mesh that is too coarse: {0:.2g} times the errors of linear elements with nodes at "
        "these radii",
        "halve the element size: this error decreases; give both results with --refinement",
        tuple(parameters),
        of_mesh=True,
    )


def mistakes(comparison: Comparison) -> Iterator[Mistake]:
    """Yield the mistakes that could be recognised in results of a scene."""
    scene, problem = written_out(comparison.scene), comparison.scene.problem
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
        yield coarse_mesh(error, None)
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
            yield coarse_mesh(error, clamped)
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
            (choice("time_scale", 1e3, 1e-3, 60.0, 1 / 60, 3600.0, 1 / 3600),),
        )
    if later and steady_load:
        yield Mistake(
            "wear coefficient",
            "a wear coefficient or a sliding speed of {0:.4g} times ours: time runs {0:.4g} "
            "times as fast",
            "compare k and v of the input, and their units; with all times multiplied by this "
            "factor the error disappears",
            (factor("time_scale"),),
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
                    "start_time",
                    0.1 * last,
                    math.log(10),
                    starts=tuple(last * part for part in (0.02, 0.1, 0.3, 0.6)),
                ),
            ),
        )
    if several and flat:
        longest = float(np.diff(comparison.times, prepend=0.0).max())
        for sign in (1, -1):
            yield Mistake(
                "first-order time step",
                lambda length: (
                    f"{'implicit' if length > 0 else 'explicit'} time steps of first order, about "
                    f"{written(abs(length), 'time', 3)} long"
                ),
                "compute with half the time step: the error is halved",
                (Parameter("step", "step", sign * longest / 20, math.log(20 * last / longest)),),
                size=abs,
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
            (choice(multiplied(*FORCE), *known),),
            "normal force",
        )
        yield Mistake(
            "normal force",
            "a load of {0:.4g} times ours, which multiplies all results",
            "compare the sum of 2 pi r p dr with the load of the scene",
            (factor(multiplied(*FORCE)),),
        )
    moduli = [
        "half_space.youngs_modulus",
        *(
            f"half_space.layers[{place}].youngs_modulus"
            for place in range(len(scene.half_space.layers))
        ),
    ]
    plane = 1 - problem.poisson_ratio**2
    if flat and bare and abs(problem.poisson_ratio) > 0.1:
        yield Mistake(
            "Poisson's ratio",
            "a half-space {0:.4g} times as stiff as ours: E in place of E/(1 - nu^2), or the "
            "reverse",
            "compute with a Poisson's ratio of 0: the error disappears",
            (choice(multiplied(*moduli), plane, 1 / plane),),
            "modulus",
        )
    if flat:
        yield Mistake(
            "modulus",
            "a half-space {0:.4g} times as stiff as ours",
            "compare the modulus of the input, and F / (2 a E*) with the first indentation",
            (factor(multiplied(*moduli)),),
        )
    if bare:
        yield Mistake(
            "radius for diameter",
            "a punch of {0:g} times the radius: a diameter in place of a radius, or the reverse",
            "look up the radius in the model beyond which pressures are zero",
            (choice(multiplied(*SIZE), 2.0, 0.5),),
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
            (choice("radius_scale", 2.0, 0.5, *[power] * (power > 1)),),
        )


def in_plane_strain(scene: Scene, reading: Reading, value: float) -> Situation:
    """Return the scene with a load times a factor, solved in plane strain."""
    return multiplied(*FORCE)(scene, reading._replace(plane_strain=True), value)


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
    wear, edges = scene.punch.wear_coefficients or [], scene.problem.ring_edges
    keys = [f"punch.wear_coefficients[{number}]" for number in range(len(wear))]
    values = sorted({*wear})
    count = len(values)
    if len(wear) > MAX_RINGS or not later or not count > 1:
        return
    for first, second in combinations(values[:MAX_MATERIALS], 2):
        others = {first: second, second: first}
        swapped = {
            key: others[each] for key, each in zip(keys, wear, strict=True) if each in others
        }
        yield Mistake(
            "swapped materials",
            "swapped wear coefficients of two materials"
            + (f", {first:.4g} and {second:.4g}" if count > 2 else ""),
            "look at the latest pressures: they must be greatest on rings that wear least",
            (choice(replaced(swapped), 1.0),),
        )
    if count > MAX_MATERIALS:
        return
    for value in values:
        # the number of a ring that alone has the material
        ring = f" (ring {wear.index(value) + 1})" if wear.count(value) == 1 else ""
        of_material = [key for key, each in zip(keys, wear, strict=True) if each == value]
        yield Mistake(
            "wear ratio",
            f"a wrong ratio of wear coefficients: that of the material with k = {value:.4g}{ring} "
            "is {0:.4g} times ours",
            "compare the wear coefficient of each material; late pressures are inverse to them",
            (factor(multiplied(*of_material), *RATIO),),
        )
    remedy = "compare the wear coefficient of this ring with that of the scene"
    for number, value in enumerate(wear if len(wear) <= MAX_SINGLE_RINGS else (), 1):
        of_ring = multiplied(keys[number - 1])
        words = f"a wear coefficient of ring {number} that is forgotten: it does not wear"
        forgotten = choice(of_ring, FORGOTTEN)
        yield Mistake("forgotten ring", words, remedy, (forgotten,), size=lambda _: 0.0)
        # a ring that alone has its material has a wrong ratio of wear coefficients
        if wear.count(value) > 1:
            words = f"a wear coefficient of ring {number} of {{0:.4g}} times ours"
            yield Mistake("wear coefficient of a ring", words, remedy, (factor(of_ring, *RATIO),))
    if edges[0] == 0 and (edges[1:-1] * 1.24 < 1).all():
        inner = [f"punch.ring_edges[{number}]" for number in range(len(wear) - 1)]
        yield Mistake(
            "ring edges",
            "edges between rings at {0:.4g} times our radii",
            "compare the radii at which late pressures jump with the ring edges of the scene",
            (factor(multiplied(*inner), (math.exp(-0.06), math.exp(0.06)), 0.21, 0.06),),
        )


def layer_mistakes(scene: Scene) -> Iterator[Mistake]:
    """Yield mistakes in the layers of a scene."""
    count, table = len(scene.half_space.layers), scene.table()
    places = range(count + (not scene.half_space.rigid))

    def described(place: int) -> str:
        return f"layer {place + 1}" if place < count else "the base below the layers"

    def key_of(place: int, name: str) -> str:
        return f"half_space.layers[{place}].{name}" if place < count else f"half_space.{name}"

    def value_of(place: float, name: str) -> float:
        return float(looked_up(table, key_of(int(place), name)))

    def without_layers(scene: Scene, place: float) -> Scene:
        below = {name: value_of(place, name) for name in ("youngs_modulus", "poisson_ratio")}
        return scene.changed({"half_space": below})

    yield Mistake(
        "layers left out",
        lambda place: (
            f"a homogeneous half-space of the material of {described(int(place))}, "
            "without the layers of the scene"
        ),
        "compare the material of the model at each depth with the layers of the scene",
        (choice(SceneChange(without_layers), *places),),
        # a layer of the modulus of the base is none
        "modulus of a layer",
        size=lambda place: value_of(place, "youngs_modulus") / value_of(0, "youngs_modulus"),
    )
    if count > MAX_LAYERS:
        return
    for place in places:
        ends = math.exp(-COARSE), math.exp(COARSE)
        for name in ["youngs_modulus", "thickness"][: 1 + (place < count)]:
            words = name.removeprefix("youngs_")
            change = multiplied(key_of(place, name))
            yield Mistake(
                f"{words} of a layer",
                f"a {words} of {described(place)} of {{0:.4g}} times ours",
                "compare Young's modulus and the thickness of each layer",
                (factor(change, ends, math.log(5), COARSE),),
            )
        ratio = value_of(place, "poisson_ratio")
        ratios = [each for each in (0.0, 0.2, 0.3, 0.4, 0.45, 0.49) if abs(each - ratio) > 0.005]
        yield Mistake(
            "Poisson's ratio of a layer",
            f"a Poisson's ratio of {described(place)} of about {{0:.2g}}",
            "compare Poisson's ratio of each layer",
            (choice(key_of(place, "poisson_ratio"), *ratios),),
        )
    for upper, lower in combinations(places, 2):
        for moved, what in (
            (("youngs_modulus", "poisson_ratio"), "materials"),
            (("youngs_modulus",), "moduli"),
        ):
            exchanged = {
                key_of(place, name): value_of(other, name)
                for place, other in ((upper, lower), (lower, upper))
                for name in moved
            }
            yield Mistake(
                "swapped layers",
                f"swapped {what} of {described(upper)} and {described(lower)}",
                "compare the material of the model at each depth with the layers of the scene",
                (choice(replaced(exchanged), 1.0),),
            )


def shape_mistakes(scene: Scene) -> Iterator[Mistake]:
    """Yield mistakes in the load, the modulus and the shape of a punch that is not flat."""
    rows = [
        ("normal force", "a load", "load.normal_force"),
        ("modulus", "a modulus of the half-space", "half_space.youngs_modulus"),
        *(
            ("radius of curvature", "a radius of curvature of the punch", f"punch.profile.{key}")
            for key in ("curvature_radius", "ball_radius")
        ),
    ]
    table = scene.table()
    # a wrong modulus of an elastic punch would have the same effect
    elastic = scene.half_space.punch_youngs_modulus is not None
    for name, words, key in rows:
        if isinstance(looked_up(table, key), float) and not (elastic and name == "modulus"):
            yield Mistake(
                name,
                f"{words} of {{0:.4g}} times ours",
                "compare this number of the input; compute with another one, and compare the "
                "change",
                (factor(multiplied(key), (0.75, 1.33), math.log(2), 0.29),),
            )


def named(mistake: Mistake, values: tuple[float, ...], comparison: Comparison) -> str:
    """Return the name of a mistake; a factor that is well-known has a name of its own."""
    if mistake.name != "constant factor":
        return mistake.name
    plane = 1 - comparison.scene.problem.poisson_ratio**2
    labels = {1e3: "units", 1e6: "units", 2 * math.pi: "2 pi missing", plane: "Poisson's ratio"}
    for number, label in labels.items():
        near = np.isclose(values[0], [number, 1 / number], rtol=MAX_FACTOR_DIFFERENCE, atol=0.0)
        if number != 1 and near.any():
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
