"""Certify the answers of problem 13: MDR and finite elements.

``python -m ringwear.studies.challenge.13_bonded_layer.make`` writes `answers.csv` in some minutes.
The finite elements end at a clamped boundary, where fields on a rigid base have decayed, so that
both methods share neither the transform of the layer nor any other formula of the ground.
"""

from collections.abc import Iterator
from itertools import product
from pathlib import Path

from ...crosscheck import Scene, run
from ..answers import write_answers

FOLDER = Path(__file__).parent
RADII_OVER_THICKNESS = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 4.0, 8.0, 20.0, 50.0)
POISSON_RATIOS = (0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.5)
CLAMPED_AT = 16.0
"""Radius of the clamped boundary, in thicknesses of the layer."""
LEAST_CLAMPED = 4.0
"""Least radius of the clamped boundary, in punch radii."""
FINEST_RTOL = {"mdr": 1e-9, "fem": 1e-8, "fem at 1/2": 1e-5}
"""Tolerances; with Poisson's ratio 1/2, finite elements accept none smaller than 1e-5."""


def case(radius_over_thickness: float, poisson_ratio: float) -> Scene:
    """Return the scene of a case: the layer has the plane strain modulus 1."""
    layer = {
        "thickness": 1 / radius_over_thickness,
        "youngs_modulus": 1 - poisson_ratio**2,
        "poisson_ratio": poisson_ratio,
    }
    return Scene.load(FOLDER / "scene.toml").changed(half_space__layers=[layer])


def stiffness(scene: Scene, method: str) -> float:
    """Return the relative stiffness F / (2 a E* d) by a method."""
    indentation = float(run(scene, methods=[method]).dataset["indentation"][0, 0])
    # the unit of displacements is F / (a E*)
    return scene.problem.units.displacement / (2 * indentation)


def values() -> Iterator[dict[str, object]]:
    """Yield a row with both values for each case."""
    for radius_over_thickness, poisson_ratio in product(RADII_OVER_THICKNESS, POISSON_RATIOS):
        scene = case(radius_over_thickness, poisson_ratio)
        radius = max(CLAMPED_AT / radius_over_thickness, LEAST_CLAMPED)
        clamped = {"far_field": "fixed", "truncation": radius}
        of_fem = FINEST_RTOL["fem at 1/2" if poisson_ratio == 0.5 else "fem"]
        by_fem = scene.changed(
            {"accuracy.rtol": of_fem, "accuracy.fem": clamped, "output.quantities": ["indentation"]}
        )
        yield {
            "radius_over_thickness": radius_over_thickness,
            "poisson_ratio": poisson_ratio,
            "quantity": "stiffness",
            "first": stiffness(scene.changed(accuracy__rtol=FINEST_RTOL["mdr"]), "mdr"),
            "second": stiffness(by_fem, "fem"),
            "unit": "1",
            "methods": "mdr and fem",
        }


if __name__ == "__main__":
    write_answers(FOLDER, values())
