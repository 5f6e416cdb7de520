"""Estimates of finite elements without a coarser solution: one pole, degree 2, highest degree."""

from dataclasses import replace

import numpy as np
import pytest

from ringwear import Scene, Stages, method, run

THREE = Scene.load("five_rings").changed(punch__rings=3, load__normal_force=1.0, methods=["fem"])


def solved(problem, name="fem"):
    return method(name).solve(problem, Stages(name))


@pytest.mark.gmsh
@pytest.mark.parametrize(
    "settings",
    [
        *({"truncation": 100.0}, {"truncation": 1e4}),
        *({"truncation": 2.0, "poles": 1}, {"truncation": 3.0, "poles": 1}),
    ],
)
def test_the_estimate_of_one_pole_is_not_that_of_a_clamped_boundary(settings):
    """With one pole, the truncation errs by (a/R)^5; a clamped boundary would err by 1.1 a/R."""
    scene = THREE.changed(wear={"times": [0.0]}, accuracy={"rtol": 1e-4, "fem": settings})
    solution = solved(scene.problem)
    assert solution.settings["poles"] == 1
    # Eq. 10
    error = abs(solution.results["indentation"][0] / 0.5 - 1)
    assert (error > 1e-4) == (settings["truncation"] < 4)
    assert error <= solution.errors["indentation"][0] <= max(10 * error, 1e-4)


def errors_of(scene, name, shown=...):
    """Return errors of a quantity of finite elements, by boundary elements, and their estimates."""
    solution, exact = solved(scene.problem), solved(replace(scene.problem, rtol=1e-6), "bem")
    error = np.abs(solution.results[name][shown] / exact.results[name][shown] - 1)
    return error, solution.errors[name][shown]


@pytest.mark.parametrize("sizes", [{"growth": 2.0}, {"ring_size": 0.5}])
def test_the_estimate_bounds_the_error_of_degree_2(sizes):
    """An earlier estimate compared two meshes of degree 2 that were equally coarse."""
    settings = {"degree": 2, "mesher": "bisection"} | sizes
    scene = THREE.changed(wear={"times": [0.0, 1.0]}, accuracy={"rtol": 1e-3, "fem": settings})
    error, estimate = errors_of(scene, "relaxation_time", slice(3))
    assert (error > 1e-3).any()
    assert (error <= estimate).all()
    anchors = run(scene).anchors
    failed = [anchor for anchor in anchors if anchor.difference > 3 * anchor.tolerance]
    assert not failed


@pytest.mark.gmsh
def test_estimates_of_running_in_times_include_a_coarse_rim():
    """The running-in begins at the flat start, whose error comes from the element at the rim."""
    sizes = {"rim_size": 0.2, "ring_size": 0.2}
    scene = THREE.changed(wear={"times": [0.0, 0.1, 1.0]}, accuracy={"rtol": 1e-3, "fem": sizes})
    for name in ("time_to_90", "time_to_99"):
        error, estimate = errors_of(scene, name)
        assert error <= estimate, name


@pytest.mark.slow
@pytest.mark.gmsh
def test_unknowns_increase_as_rtol_decreases():
    """Earlier, degrees next to edges decreased with rtol once the highest degree was reached."""
    unknowns, highest = [], []
    for rtol in (1e-6, 1e-7, 1e-8, 1e-9):
        problem = replace(THREE.problem, rtol=rtol)
        solid = method("fem").discretise(problem, Stages("fem")).half_space.solid
        unknowns.append(solid.unknowns)
        highest.append(solid.degree)
    assert highest[-2:] == [16, 16]
    assert (np.diff(unknowns) > 0).all()
    counts = [
        solved(replace(THREE.problem, rtol=rtol), "mdr").unknowns for rtol in (1e-7, 1e-8, 1e-9)
    ]
    assert (np.diff(counts) > 0).all()


@pytest.mark.slow
@pytest.mark.gmsh
def test_rms_slopes_at_the_finest_rtol_against_boundary_elements():
    """The RMS slope agrees with boundary elements to rtol; it was once wrong by 12 rtol."""
    problem = replace(THREE.changed(wear__times={"tau": [0.01, 0.1, 1.0, 5.0]}).problem, rtol=1e-8)
    exact = solved(replace(problem, rtol=1e-9, compared_on=problem.face), "bem")
    solution = solved(problem)
    slopes = solution.results["rms_slope"] / exact.results["rms_slope"]
    assert np.abs(slopes - 1).max() < 1e-8
