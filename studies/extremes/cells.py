"""The cells of the map of limits.

Families of scenes over two parameters, each by the methods that they concern.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ..problem.scene import Scene

Changes = dict[str, Any]  # of a scene, as `Scene.changed` takes them
Axis = dict[Any, Changes]  # what each value of a parameter changes

METHODS = DIRECT, MDR, FEM = "direct", "mdr", "fem"
RTOL = {DIRECT: 1e-4, MDR: 1e-3, FEM: 1e-2}
START: Changes = {"wear__times": [0.0]}
RUNNING: Changes = {"wear__times": [0.0, 1.0], "accuracy__rtol": 1e-3}


class Cell(NamedTuple):
    """A scene by one method, at values `x` and `y`.

    If `scaled`, its whole run in the scene's own units is judged.
    """

    family: str
    method: str
    x: float | str
    y: float | str
    scene: Scene
    scaled: bool


def axis(
    key: str, values: Iterable[Any], entry: Callable[[Any], Any] = lambda value: value
) -> Axis:
    """A parameter that sets one key of a scene."""
    return {value: {key: entry(value)} for value in values}


def fem(**settings: Any) -> Changes:
    """Settings of the finite elements."""
    return {f"accuracy__fem__{key}": value for key, value in settings.items()}


def span(low: float, high: float, count: int) -> list[float]:
    """Values in equal ratios."""
    return [float(f"{value:.9g}") for value in np.geomspace(low, high, count)]


def wear(high: float, count: int) -> Axis:
    """Ratios of wear coefficients, as far below 1 as above."""
    return axis("punch__wear_coefficients", span(1 / high, high, count), lambda ratio: [1.0, ratio])


def all_cells(poisson_ratio: float, quick: bool) -> Iterator[Cell]:
    """Every cell.

    Some values of each parameter when quick. Cells that differ in y alone follow one another.
    """
    punch = {"radius": 1.0, "rings": 3, "wear_coefficients": [1.0, 10.0]}
    solid, load = (
        {"plane_strain_modulus": 1.0, "poisson_ratio": poisson_ratio},
        {"normal_force": 1.0},
    )
    usual = Scene.from_table({"punch": punch, "half_space": solid, "load": load})

    def family(
        name: str, methods: Iterable[str], xs: Axis, ys: Axis, fixed: Changes, scaled: bool = False
    ) -> Iterator[Cell]:
        """Scenes over two parameters, ``x × y``; `fixed` is changed in all of them."""
        if quick:  # every fourth value, and the last
            xs, ys = (
                {one: values[one] for one in (*list(values)[::4], list(values)[-1])}
                for values in (xs, ys)
            )
        for x, method, y in product(xs, methods, ys):
            changes = {"methods": [method], "accuracy__rtol": RTOL[method]} | fixed | xs[x] | ys[y]
            yield Cell(name, method, x, y, usual.changed(**changes), scaled)

    few, ratios, many = wear(1e8, 3), wear(1e8, 9), wear(1e8, 17)
    late = {
        ratio: change | {"wear__times": [0.0, 100 / min(1, ratio)]}
        for ratio, change in many.items()
    }
    name, key = "rings × k2/k1", "punch__rings"
    yield from family(name, METHODS, axis(key, (1, 2, 3, 5, 8)), late, {})
    yield from family(name, METHODS, axis(key, (16, 32, 64)), many, {})
    if not quick:  # more rings are slow, not the less certain for it
        yield from family(name, [DIRECT], axis(key, (128, 256, 1024)), few, {})
        yield from family(name, [MDR, FEM], axis(key, [128]), many, {"accuracy__rtol": 0.1})
        yield from family(name, [MDR, FEM], axis(key, [256]), few, {"accuracy__rtol": 0.1})
    widths = axis("punch__width_ratio", span(1e-4, 1e4, 17))
    yield from family("h2/h1 × k2/k1", METHODS, widths, ratios, {"punch__rings": 5})

    by_edges, edges = {"punch__rings": None}, "punch__ring_edges"
    narrow = axis(edges, span(1e-9, 0.1, 17), lambda width: [0.5, 0.5 + width, 1.0])
    at_axis = axis(edges, span(1e-9, 0.1, 9), lambda width: [width, 0.5, 1.0])
    at_rim = axis(edges, span(1e-9, 0.1, 9), lambda width: [0.5, 1 - width, 1.0])
    yield from family("ring width/a × k2/k1", METHODS, narrow, ratios, by_edges | START)
    yield from family("ring width/a × ring at", METHODS, at_axis, {"axis": {}}, by_edges)
    yield from family("ring width/a × ring at", METHODS, at_rim, {"rim": {}}, by_edges)

    poisson = (
        -0.9,
        -0.7,
        -0.5,
        -0.2,
        0.0,
        0.2,
        0.3,
        0.4,
        0.45,
        0.49,
        0.499,
        0.4999,
        0.49999,
        0.4999999,
        0.5,
    )
    truncations = 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 50.0, 100.0, 1e3, 1e4, 1e5, 1e6
    triangles = {f"P{degree}": fem(degree=degree) for degree in (2, 3, 4)}
    kinds = product((2, 3, 4), ("gmsh", "bisection"))
    default: Axis = {"default": {}}
    elements = default | {
        f"P{degree} {mesher}": fem(degree=degree, mesher=mesher) for degree, mesher in kinds
    }
    far_fields = (
        default
        | {"default, fixed": fem(far_field="fixed")}
        | triangles
        | {
            "P4, 1 pole": fem(degree=4, poles=1),
            "P4, 6 poles": fem(degree=4, poles=6),
            "P4 bisection": fem(mesher="bisection"),
            "P4, fixed": fem(degree=4, far_field="fixed"),
        }
    )
    yield from family(
        "Poisson's ratio × elements",
        [FEM],
        axis("half_space__poisson_ratio", poisson),
        elements,
        RUNNING,
    )
    yield from family(
        "R/a × far field",
        [FEM],
        axis("accuracy__fem__truncation", truncations),
        far_fields,
        RUNNING | START,
    )

    degrees, sizes = axis("accuracy__mdr__degree", (1, 2, 4, 8, 12, 16)), span(1e-12, 0.5, 13)
    for where in ("rim_size", "ring_size"):
        yield from family(
            f"{where}/a × degree", [MDR], axis(f"accuracy__mdr__{where}", sizes), degrees, RUNNING
        )
        yield from family(
            f"{where}/a × elements",
            [FEM],
            axis(f"accuracy__fem__{where}", sizes),
            elements,
            RUNNING,
        )
    gradings, growths = (
        axis("accuracy__mdr__grading", span(0.05, 0.8, 9)),
        axis("accuracy__fem__growth", span(0.12, 2.0, 9)),
    )
    yield from family("grading × degree", [MDR], gradings, degrees, RUNNING)
    yield from family("growth × degree", [FEM], growths, triangles, RUNNING)
    rtols, rings = axis("accuracy__rtol", span(1e-9, 0.1, 9)), axis(key, (1, 2, 3))
    yield from family("rtol × rings", [MDR], rtols, rings, RUNNING)
    yield from family(
        "rtol × rings", [FEM], {rtol: rtols[rtol] for rtol in rtols if rtol > 5e-7}, rings, RUNNING
    )

    times = axis("wear__times", span(1e-12, 1e12, 25), lambda time: [time])
    yield from family(
        "t E* k1 v0/a × k2/k1", [MDR, FEM], times, wear(1e6, 7), {"accuracy__rtol": 1e-3}
    )
    steps, marches = (
        axis("wear__step", span(3e-6, 1e2, 13)),
        axis("wear__march", ("implicit", "explicit")),
    )
    yield from family(
        "step × march", [MDR], steps, marches, {"wear__times": [0.01], "punch__rings": 2}
    )

    two = START | {"punch__rings": 2, "accuracy__rtol": 1e-2}
    radius, modulus, decades = (
        "punch__radius",
        "half_space__plane_strain_modulus",
        span(1e-15, 1e15, 11),
    )
    radii, forces = axis(radius, span(1e-9, 1e3, 13)), axis("load__normal_force", decades)
    moduli, speeds = axis(modulus, span(1e-9, 1e15, 13)), axis("load__sliding_speed", decades)
    yield from family("a × F", [DIRECT, MDR], radii, forces, two, scaled=True)
    yield from family("E* × v0", [DIRECT, MDR], moduli, speeds, two, scaled=True)
    radii, moduli = axis(radius, span(1e-9, 1e3, 4)), axis(modulus, span(1e-9, 1e15, 5))
    yield from family("a × E*", [FEM], radii, moduli, two, scaled=True)
