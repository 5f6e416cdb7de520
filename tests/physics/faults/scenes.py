"""One scene of each kind for tests with faults, and the rules by which a fault counts as noticed.

Two methods share each fault, so that only anchors can detect it.
"""

from dataclasses import replace
from functools import cache

import numpy as np
from given import judge

from ringwear import Result, Scene, run
from ringwear.studies.crosscheck.result.table import answers_of

from .changes import Change

RINGS = {
    "radius": "2 mm",
    "ring_edges": ["0.5 mm", "0.8 mm", "1.3 mm", "1.6 mm", "2 mm"],
    "wear_coefficients": ["1e-6 mm^3/(N m)", "1e-5 mm^3/(N m)"],
}
K_OF_RADIUS = {
    "radius": "2 mm",
    "rings": 2,
    "wear_coefficient": {
        "radii": ["0 mm", "0.7 mm", "2 mm"],
        "values": ["1e-6 mm^3/(N m)", "1e-5 mm^3/(N m)", "3e-6 mm^3/(N m)"],
    },
}
SPHERE = {
    "radius": "2 mm",
    "ring_edges": ["0.9 mm", "2 mm"],
    "wear_coefficients": ["1e-6 mm^3/(N m)", "3e-6 mm^3/(N m)"],
    "profile": {"kind": "parabola", "curvature_radius": "200 mm"},
}
SPEEDS = {"times": [0, 1000.0], "values": ["0.1 m/s", "0.5 m/s"]}
RISING = {
    "normal_force": {"times": [0, 500.0, 2000.0], "values": ["5 N", "20 N", "40 N"]},
    "sliding_speed": SPEEDS,
}
# the force falls so fast that the rim loses contact
UP_AND_DOWN = {
    "normal_force": {"times": [0, 500.0, 2000.0], "values": ["5 N", "40 N", "5 N"]},
    "sliding_speed": SPEEDS,
}
HELD = {"indentation": "1 um", "sliding_speed": "0.5 m/s"}


def _scene(rtol: float, punch: dict, load: dict | None = None, times: tuple = ()) -> Scene:
    return Scene.from_table(
        {
            "methods": ["mdr"],
            "units": "SI",
            "punch": punch,
            "half_space": {"youngs_modulus": "3 GPa", "poisson_ratio": 0.4},
            "load": load or {"normal_force": "20 N", "sliding_speed": "0.5 m/s"},
            "wear": {"times": list(times or (0.0, 10.0, 100.0, 1000.0, 1e4))},
            "accuracy": {"rtol": rtol},
        }
    )


SCENES = {
    "flat": _scene(1e-4, RINGS),
    "graded": _scene(1e-4, K_OF_RADIUS),
    "rising": _scene(1e-4, RINGS, RISING),
    "up_and_down": _scene(1e-3, RINGS, UP_AND_DOWN),
    "held": _scene(1e-4, RINGS, HELD),
    "sphere": _scene(3e-3, SPHERE),
}
# relative sizes of faults: ten times rtol
SIZES = {kind: 10 * scene.problem.rtol for kind, scene in SCENES.items()}
# kinds of scenes in which edges of the contact move
MOVING = ("up_and_down", "sphere")
# lengths that are relative to the indentation
DEPTHS = ("profile", "displacement", "indentation", "displacement_centre", "displacement_max")
# quantities of every history
HISTORY = [
    "pressure",
    "profile",
    "displacement",
    "indentation",
    "displacement_centre",
    "displacement_max",
    "rms_slope",
    "ring_force",
]


STEADY = [
    "steady_pressure",
    "steady_profile",
    "steady_displacement_max",
    "steady_rms_slope",
    "steady_wear_rate",
]


def shared(scene: Scene) -> Result:
    """Return a run by two methods that have the same solution."""
    solution = run(scene, methods=["mdr"]).solutions["mdr"]
    return judge(scene, mdr=solution, twin=solution)


@cache
def healthy(kind: str) -> Result:
    """Return the run of a kind of scene without a fault."""
    return shared(SCENES[kind])


def with_table(result: Result, change: Change, alone: bool = False) -> Result:
    """Return a copy of a result whose table is changed, for both methods or for one of them."""
    table, problem = result.table, result.scene.problem
    values = {name: np.array(of.values) for name, of in table.variables.items()}
    of_methods = [*table.data_vars]
    # views of the last method
    change(values | {name: values[name][-1, ...] for name in of_methods}, problem.radii, problem)
    for name in () if alone else of_methods:
        values[name][...] = values[name][-1:]
    data_vars, coords = (
        {name: of._replace(values=values[name]) for name, of in part.items()}
        for part in (table.data_vars, table.coords)
    )
    wrong = replace(table, data_vars=data_vars, coords=coords)
    answers = answers_of(wrong)
    judgement = replace(result.judgement, table=wrong, answers=answers)
    return replace(result, table=wrong, answers=answers, judgement=judgement)


def with_results(result: Result, change: Change) -> Result:
    """Return the result of two methods that share a solution, changed everywhere alike."""
    solution, problem = result.solutions["mdr"], result.scene.problem
    changed = {}
    for name, radii in (("results", problem.radii), ("compared", problem.face.radii)):
        changed[name] = {key: np.array(of) for key, of in getattr(solution, name).items()}
        change(changed[name], radii, problem)
    wrong = replace(solution, **changed)
    return judge(result.scene, mdr=wrong, twin=wrong)
