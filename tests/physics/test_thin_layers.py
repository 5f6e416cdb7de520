"""Thin bonded layers, also of nu = 1/2, against solutions that share no formula with ringwear."""

import numpy as np
import pytest
from ball_on_pad import Ball, pressed_to
from groups import nightly
from independent_layer import relaxation_times, start
from layered_disc import Layer, fields_under_uniform_pressure, surface_displacements
from natural import natural

from ringwear import SceneError, differences, run
from ringwear.studies.crosscheck.methods.error_factors import error_factor


def on_a_rigid_base(thickness, ratio, rtol=1e-4, methods="mdr fem", fem=(), **tables):
    """Return a scene on one layer whose plane strain modulus is 1."""
    layer = {"thickness": thickness, "youngs_modulus": 1 - ratio**2, "poisson_ratio": ratio}
    return natural(
        tables.pop("punch", {"wear_coefficient": 1.0}),
        methods=methods,
        half_space={"rigid": True, "layers": [layer]},
        accuracy={"rtol": rtol, "fem": dict(fem)},
        **{"wear": {"times": [0.0, 0.01], "steady": False}} | tables,
    )


def values(result, solver):
    """Return the indentation of the start and the eight slowest relaxation times of a method."""
    reported = result.dataset.sel(solver=solver)
    return float(reported.indentation[0]), reported.relaxation_time.values[:8]


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("thickness", "ratio", "rtol", "methods"),
    [
        *((0.2, 0.3, 1e-6, "mdr"), *nightly((0.05, 0.5, 1e-6, "mdr")), (0.02, 0.4999, 1e-6, "mdr")),
        (0.02, 0.45, 1e-2, "mdr fem"),
        *nightly((0.02, 0.4999, 1e-4, "mdr fem"), (0.01, 0.3, 1e-3, "mdr fem")),
        *nightly((0.01, 0.4999, 1e-2, "mdr fem")),
    ],
)
def test_slowest_modes_of_thin_layers(thickness, ratio, rtol, methods):
    """Their wavelengths are 3 h to 7 h, which elements under the face resolve."""
    result = run(on_a_rigid_base(thickness, ratio, rtol, methods))
    *others, last = methods.split()
    assert result.verdict == ("agree" if others else "undecided")
    indentation, times = values(result, last)
    assert others or indentation == pytest.approx(start(thickness, ratio), rel=1e-9)
    assert times == pytest.approx(relaxation_times(thickness, ratio), rel=1e-9)
    assert result.solutions[last].errors["relaxation_time"][:8].max() <= rtol


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("thickness", "rtol"),
    [
        *nightly((0.2, 1e-5)),
        (0.05, 1e-2),
        *nightly((0.01, 1e-4)),
    ],
)
def test_incompressible_layers(thickness, rtol):
    result = run(on_a_rigid_base(thickness, 0.5, rtol))
    assert result.verdict == "agree"
    indentation, times = values(result, "fem")
    errors = result.solutions["fem"].errors
    missed = abs(indentation / start(thickness, 0.5) - 1)
    assert missed <= error_factor("incompressible layers") <= errors["indentation"][0]
    missed = np.abs(times / relaxation_times(thickness, 0.5) - 1)
    assert (missed <= errors["relaxation_time"][:8]).all()


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("thickness", "ratio", "fem"),
    [(0.02, 0.4999999, {}), *nightly((0.02, 0.499995, {})), (0.1, 0.5, {"far_field": "fixed"})],
)
def test_starts_on_almost_incompressible_layers(thickness, ratio, fem):
    """Ratios between that of the model and 1/2 are not taken for 1/2.

    On a thin layer the field ends within a few thicknesses from the punch, so that the outer
    boundary may be clamped.
    """
    result = run(on_a_rigid_base(thickness, ratio, methods="fem", fem=fem))
    assert values(result, "fem")[0] == pytest.approx(start(thickness, ratio), rel=5e-8)


@pytest.mark.slow
@pytest.mark.gmsh
def test_fields_inside_incompressible_layers():
    """Displacements and stresses under a uniform pressure, the steady state of one material."""
    thickness = 0.05
    result = run(on_a_rigid_base(thickness, 0.5, methods="fem", wear={"times": [0.0, 0.01]}))
    inside, (r, z) = result.inside(), result.inside().points
    within = (z > 0.3 * thickness) & (z < thickness) & (np.abs(r - 1) > 0.2) & (r < 1.5)
    some = np.flatnonzero(within)[::40]
    layers = [Layer(thickness, 0.75, 0.5)]
    exact = fields_under_uniform_pressure(layers, 0, r[some], z[some])
    displacement, stress = (field / np.pi for field in exact)
    steady = inside.labels.index("steady")
    indentation = start(thickness, 0.5)
    missed = np.abs(inside.displacement[steady, some] - displacement).max() / indentation
    assert missed <= error_factor("incompressible inside") <= inside.errors["displacement"][steady]
    missed = np.abs(inside.stress[steady, some] - stress).max() * np.pi
    assert missed <= error_factor("incompressible inside") <= inside.errors["stress"][steady]
    # under the flat face
    face = (z == 0) & (r < 0.8)
    missed = np.abs(inside.displacement[0, face, 1] / indentation - 1).max()
    assert missed <= inside.errors["displacement"][0] <= 1e-4


@pytest.mark.gmsh
@pytest.mark.slow
def test_early_slopes_of_rings_on_an_incompressible_layer():
    """Roundoff of slopes in small elements stays below its estimate, and far below one per cent."""
    punch = {"ring_edges": [0.5, 1.0], "wear_coefficients": [1.0, 0.1]}
    wear = {"times": [0.0, 1e-6, 1e-4, 1e-2], "steady": False}
    result = run(on_a_rigid_base(0.2, 0.5, punch=punch, wear=wear))
    assert result.verdict == "agree"
    mdr, fem = (result.solutions[name] for name in ("mdr", "fem"))
    problem = result.scene.problem
    missed = differences(fem.compared, mdr.compared, problem.face)["rms_slope"]
    stated = fem.errors["rms_slope"] + mdr.errors["rms_slope"]
    assert (missed <= stated).all()
    assert missed.max() <= 1e-4


@pytest.mark.gmsh
@pytest.mark.slow
@pytest.mark.parametrize(
    "punch",
    [
        {"inner_radius": 0.4, "wear_coefficient": 1.0},
        {
            "ring_edges": [0.3, 0.305, 0.31, 0.315, 0.32, 1.0],
            "wear_coefficients": [1.0, 0.2, 0.5, 0.1, 1.0, 0.3],
        },
    ],
    ids=["hollow", "narrow rings"],
)
def test_punches_on_thin_layers(punch):
    result = run(on_a_rigid_base(0.02, 0.4999, punch=punch))
    assert result.verdict == "agree"


@pytest.mark.slow
@pytest.mark.gmsh
def test_a_low_degree_on_a_thin_layer_is_undecided_and_not_wrong():
    """A user's degree is kept: the estimate covers its error, and the remedy is to leave it out."""
    result = run(on_a_rigid_base(0.02, 0.4999, 1e-2, fem={"degree": 6}))
    assert result.verdict != "disagree"
    assert all(one.difference <= one.uncertainty for one in result.agreement)
    undecided = [one for one in result.agreement if one.verdict == "undecided"]
    assert undecided
    assert all("sizes given for fem" in one.remark for one in undecided)


@pytest.mark.parametrize("thickness", [0.0099, 0.006])
def test_layers_that_are_too_thin_are_refused(thickness):
    with pytest.raises(SceneError, match=r"thinner than 0\.01 a cannot be meshed: leave fem out"):
        run(on_a_rigid_base(thickness, 0.3))


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [0.006, *nightly(0.003)])
def test_a_ball_on_a_thin_coat_against_an_independent_equation(thickness):
    coat, base = Layer(thickness, 10.0, 0.3), Layer(np.inf, 1.0, 0.3)
    modulus = 10.0 / (1 - 0.3**2)

    def compliance(s):
        return surface_displacements([coat, base], s) * s / 2 * modulus

    ball = Ball(4.0, thickness, 0.3, compliance)
    expected = pressed_to(ball, contact_radius=0.6, radius=0.3)
    layer = {"thickness": thickness, "youngs_modulus": 10.0, "poisson_ratio": 0.3}
    result = run(
        natural(
            {"wear_coefficient": 1.0, "profile": {"kind": "ball", "ball_radius": 4.0}},
            methods="mdr bem",
            half_space={"youngs_modulus": 1.0, "poisson_ratio": 0.3, "layers": [layer]},
            load={"normal_force": expected.normal_force * modulus},
            wear={"times": [0.0]},
            accuracy={"rtol": 1e-4},
            output={"radii": [0.3]},
        )
    )
    for name in ("indentation", "contact_radius"):
        start = result.dataset[name].sel(time=0.0)
        np.testing.assert_allclose(start, getattr(expected, name), rtol=1e-7)
    pressure = result.dataset.pressure.sel(time=0.0, radius=0.3)
    np.testing.assert_allclose(pressure, expected.pressure * modulus, rtol=1e-8)
