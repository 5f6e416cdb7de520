"""Constants of the size rules matter: with a worse value, the error of a quantity is far greater.

Errors are those of a single solution against an independent reference. A run would solve again
with finer sizes, which would hide the effect of the constant.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from groups import nightly
from independent import exact_results

from ringwear import Scene, Stages, differences, method
from ringwear.meshes import sizes
from ringwear.studies.crosscheck.sizes import (
    degrees,
    finite_elements,
    quads,
    radial,
    ring_edges,
    triangles,
)

FIVE = Scene.load("five_rings").changed(wear__times=[0.0, 1e-4, 1e-2, 0.5], accuracy__rtol=1e-4)
STEADY = FIVE.changed(wear__times=[])
TRIANGLES = FIVE.changed(
    wear__times=[0.0, 0.01, 0.5], accuracy__rtol=1e-3, accuracy__fem__mesher="bisection"
)
SCENES = {"early": FIVE, "steady": STEADY, "triangles": TRIANGLES}


@cache
def exact_of(scene):
    return exact_results(SCENES[scene].problem)


def error_over_rtol(scene, name, quantity):
    # a problem of its own: the sizes of a problem are chosen once
    problem = replace(SCENES[scene].problem)
    solution = method(name).solve(problem, Stages(name))
    errors = np.atleast_1d(differences(solution.compared, exact_of(scene), problem.face)[quantity])
    # the three slowest relaxation times are compared
    shown = errors[:3] if quantity == "relaxation_time" else errors
    return float(shown.max()) / problem.rtol


@pytest.mark.gmsh
@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "constant", "factor", "scene", "name", "quantity"),
    [
        (ring_edges, "SLOPE_SHARE", 1000, "steady", "mdr", "steady_rms_slope"),
        (radial, "RADIAL_GRADING", 0.2, "early", "mdr", "pressure"),
        (quads, "EXTRA_DISPLACEMENT_DEGREES", -0.5, "early", "fem", "pressure"),
        *nightly(
            (ring_edges, "SLOPE_SHARE_AT_RIM", 100, "early", "mdr", "rms_slope"),
            (degrees, "MOST_RELAXED", 4, "early", "fem", "rms_slope"),
            (sizes, "SLOPE_AMPLITUDE", 0.01, "early", "fem", "rms_slope"),
            (quads, "GROWTH", 4, "early", "fem", "relaxation_time"),
            (finite_elements, "MAX_TRUNCATION_LOSS", 1e7, "early", "fem", "rms_slope"),
        ),
        (triangles, "TRIANGLE_GROWTH", 4, "triangles", "fem", "relaxation_time"),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_a_quantity_errs_more_with_a_worse_constant(
    monkeypatch, module, constant, factor, scene, name, quantity
):
    error = error_over_rtol(scene, name, quantity)
    assert error <= 1
    monkeypatch.setattr(module, constant, factor * getattr(module, constant))
    # otherwise this limit would hide the effect of TRIANGLE_GROWTH
    monkeypatch.setattr(triangles, "MAX_TRIANGLE_GROWTH", np.inf)
    assert error_over_rtol(scene, name, quantity) > 3 * error
