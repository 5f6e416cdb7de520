"""Certify the answers of problem 15: Hankel's transform and finite elements.

``python -m ringwear.studies.challenge.15_three_layers.make`` writes `answers.csv` in some seconds.
A worn punch of one material presses uniformly in its steady state. The fields under this pressure
are computed by `layered_disc.py` and by ringwear's finite elements, which share no formula but that
of the far field beyond twelve radii.
"""

from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path

import numpy as np

from ...crosscheck import Scene, run
from ..answers import write_answers
from .layered_disc import Layer, OnAxis, fields_on_axis

FOLDER = Path(__file__).parent
UNITS = {"displacement": "in", "stress_zz": "psi", "stress_rr": "psi"}
ACCURACY = {"accuracy.rtol": 1e-8, "accuracy.fem": {"truncation": 12.0, "growth": 0.4}}
"""Tolerance and mesh of the finite elements; lengths are in punch radii."""


def layers_of(scene: Scene) -> list[Layer]:
    """Return the layers of a scene and the half-space below them, in the units of the scene."""
    ground = scene.table()["half_space"]
    rows = [*ground["layers"], ground | {"thickness": np.inf}]
    return [Layer(*(row[name] for name in Layer._fields)) for row in rows]


def points(layers: list[Layer]) -> Iterator[tuple[int, float]]:
    """Yield the index of the layer and the depth of the surface and both sides of interfaces."""
    yield 0, 0.0
    for above, depth in enumerate(accumulate(layer.thickness for layer in layers[:-1])):
        yield above, depth
        yield above + 1, depth


def by_hankel(scene: Scene) -> list[OnAxis]:
    """Return the fields at each point by Hankel's transform."""
    radius, pressure = scene.punch.radius, scene.table()["load"]["mean_pressure"]
    layers = layers_of(scene)
    scaled = [layer._replace(thickness=layer.thickness / radius) for layer in layers]
    fields = [fields_on_axis(scaled, layer, depth / radius) for layer, depth in points(layers)]
    return [
        OnAxis(
            each.displacement * radius * pressure,
            each.stress_zz * pressure,
            each.stress_rr * pressure,
        )
        for each in fields
    ]


def by_finite_elements(scene: Scene) -> list[OnAxis]:
    """Return the fields at each point in the steady state by finite elements."""
    inside = run(scene.changed(ACCURACY), methods=["fem"]).inside()
    steady, (r, z) = inside.labels.index("steady"), inside.points
    units = scene.problem.units
    fields = []
    for layer, depth in points(layers_of(scene)):
        at_depth = np.isclose(z, depth / scene.punch.radius, rtol=1e-12, atol=1e-12)
        here = np.flatnonzero((r == 0) & at_depth & (inside.layers == layer))[0]
        stress_rr, stress_zz = inside.stress[steady, here, :2] * units.pressure
        displacement = inside.displacement[steady, here, 1] * units.displacement
        fields.append(OnAxis(displacement, stress_zz, stress_rr))
    return fields


def values() -> Iterator[dict[str, object]]:
    """Yield a row with both values for each point and quantity; layers are counted from 1."""
    scene = Scene.load(FOLDER / "scene.toml")
    rows = zip(points(layers_of(scene)), by_hankel(scene), by_finite_elements(scene), strict=True)
    for (layer, depth), first, second in rows:
        for quantity, unit in UNITS.items():
            yield {
                "depth": depth,
                "layer": layer + 1,
                "quantity": quantity,
                "first": getattr(first, quantity),
                "second": getattr(second, quantity),
                "unit": unit,
                "methods": "Hankel's transform and fem",
            }


if __name__ == "__main__":
    write_answers(FOLDER, values())
