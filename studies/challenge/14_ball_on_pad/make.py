"""Certify the answers of problem 14: MDR, finite elements and Fredholm's equation.

``python -m ringwear.studies.challenge.14_ball_on_pad.make`` writes `answers.csv` in a minute. With
Poisson's ratio 1/2, finite elements solve no contact that moves, and `fredholm.py` replaces them.
It also replaces the MDR in pressures, which have errors of some 1e-7 in the MDR. Boundary elements
are of no use here: they share the transform of the layer and the fitted elements with the MDR, and
therefore its errors.
"""

from collections.abc import Iterator
from itertools import product
from pathlib import Path

from ...crosscheck import Scene, run
from ..answers import write_answers
from .fredholm import Ball, pressed_by

FOLDER = Path(__file__).parent
FORCES = (1e-4, 1e-3, 1e-2, 1e-1)
POISSON_RATIOS = (0.3, 0.45, 0.5)
RADIUS = 0.01
"""Radius at which pressures are compared."""
RTOL = 1e-6
UNITS = {"indentation": "a", "contact_radius": "a", "pressure": "E*"}
EQUATION = "Fredholm's equation"


def case(normal_force: float, poisson_ratio: float) -> Scene:
    """Return the scene of a case: the pad has the plane strain modulus 1."""
    scene = Scene.load(FOLDER / "scene.toml")
    pad = {
        "thickness": scene.half_space.layers[0].thickness,
        "youngs_modulus": 1 - poisson_ratio**2,
        "poisson_ratio": poisson_ratio,
    }
    return scene.changed(
        half_space__layers=[pad],
        load__normal_force=normal_force,
        accuracy__rtol=RTOL,
        output__radii=[RADIUS],
        output__quantities=[*UNITS],
    )


def by_equation(scene: Scene) -> dict[str, float]:
    """Return the indentation, the contact radius and the pressure by Fredholm's equation."""
    table = scene.table()
    (pad,) = table["half_space"]["layers"]
    ball = Ball(table["punch"]["profile"]["ball_radius"], pad["thickness"], pad["poisson_ratio"])
    return pressed_by(ball, table["load"]["normal_force"], RADIUS)._asdict()


def values() -> Iterator[dict[str, object]]:
    """Yield a row with both values for each case and quantity."""
    for normal_force, poisson_ratio in product(FORCES, POISSON_RATIOS):
        incompressible = poisson_ratio == 0.5
        methods = ["mdr"] if incompressible else ["mdr", "fem"]
        scene = case(normal_force, poisson_ratio)
        dataset = run(scene, methods=methods).dataset.squeeze(["time", "radius"])
        found = {
            name: {key: float(dataset[key].sel(solver=name)) for key in UNITS} for name in methods
        }
        found[EQUATION] = by_equation(scene)
        for quantity, unit in UNITS.items():
            pair = ("mdr", EQUATION if incompressible else "fem")
            if quantity == "pressure":
                if incompressible:
                    continue
                pair = (EQUATION, "fem")
            yield {
                "normal_force": normal_force,
                "poisson_ratio": poisson_ratio,
                "quantity": quantity,
                "first": found[pair[0]][quantity],
                "second": found[pair[1]][quantity],
                "unit": unit,
                "methods": " and ".join(pair),
            }


if __name__ == "__main__":
    write_answers(FOLDER, values())
