"""Elements of low degree, and the uniform grid of the paper: errors, estimates and refusals."""

import numpy as np
import pytest
from groups import nightly

from ringwear import Scene, SceneError, Stages, differences, method, run

FIVE = Scene.load("five_rings")
LOW = [
    *(pytest.param("quads", degree, marks=pytest.mark.gmsh) for degree in (1, 2, 3)),
    pytest.param("gmsh", 1, marks=pytest.mark.gmsh),
    ("bisection", 1),
]


@pytest.fixture(scope="module")
def exact():
    """Solution of the five rings by MDR at rtol 1e-7, used as exact."""
    return run(FIVE.changed(accuracy__rtol=1e-7), methods=["mdr"]).solutions["mdr"]


@pytest.mark.parametrize("poisson_ratio", [*nightly(0.0, 0.45), 0.49])
@pytest.mark.parametrize(("mesher", "degree"), LOW)
def test_estimates_bound_the_errors_of_low_degrees(exact, mesher, degree, poisson_ratio):
    """This includes a ratio near incompressibility, where linear elements begin to lock."""
    settings = {"mesher": mesher, "degree": degree}
    scene = FIVE.changed(accuracy__fem=settings, half_space__poisson_ratio=poisson_ratio)
    solution = run(scene, methods=["fem"]).solutions["fem"]
    assert solution.settings["degree"] == degree
    assert solution.settings["mesher"] == mesher
    errors = differences(solution.compared, exact.compared, scene.problem.face)
    for name, error in errors.items():
        assert error.max() <= solution.errors[name].max(), name
    # errors are a few per cent at most
    assert errors["indentation"].max() <= 0.03
    assert errors["pressure"].max() <= 0.1


@pytest.mark.parametrize("ratio", [0.495, 0.5])
def test_linear_elements_are_refused_where_they_lock(ratio):
    locking = FIVE.changed(accuracy__fem__degree=1, half_space__poisson_ratio=ratio)
    with pytest.raises(SceneError, match=r"degree = 1 locks.*give degree = 2 or more"):
        run(locking, methods=["fem"])


def test_shaped_punches_refuse_degrees_above_four():
    with pytest.raises(SceneError, match="degree = 1 to 4 without mesher = 'quads'"):
        run(Scene.load("sphere").changed(accuracy__fem__degree=6), methods=["fem"])


@pytest.mark.slow
def test_linear_triangles_agree_with_mdr_on_a_sphere():
    """In a spreading contact, both methods agree within the sum of their estimates."""
    scene = Scene.load("sphere").changed(accuracy__rtol=1e-2, wear__steady=False)
    result = run(scene.changed(accuracy__fem__degree=1), methods=["mdr", "fem"])
    assert result.verdict != "disagree"
    assert result.solutions["fem"].half_space.solid.degree == 1
    indentation = result.dataset.indentation
    error = np.abs(indentation.sel(solver="fem") / indentation.sel(solver="mdr") - 1)
    assert float(error.max()) <= 0.02


@pytest.mark.parametrize("springs", [60, 120])
@pytest.mark.parametrize(("rings", "ratio"), [(5, 10.0), (2, 0.1), (3, 30.0), (6, 0.3), (1, 1.0)])
def test_errors_are_below_their_estimates(rings, ratio, springs):
    """At each time, in the norm of each quantity; the reference is by the MDR at rtol 1e-5."""
    scene = Scene.load("five_rings").changed(
        punch__rings=rings,
        punch__wear_coefficients=[1.0, ratio],
        accuracy__rtol=1e-5,
        accuracy__mdr__grid=springs,
        wear={"times": [0.0, 0.001, 0.01, 0.1, 0.5, 2.0], "steady": False},
    )
    problem = scene.problem
    grid, exact = (method(name).solve(problem, Stages(name)) for name in ("mdr-grid", "mdr"))
    for name in ("indentation", "displacement", "profile", "pressure", "rms_slope", "ring_force"):
        true_errors = differences(grid.compared, exact.compared, problem.face)[name]
        assert (true_errors <= grid.compared_error(problem, name)).all(), name
