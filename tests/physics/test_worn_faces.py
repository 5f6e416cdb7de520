"""Slopes and displacements of worn faces against the steady state in closed form."""

import numpy as np
import pytest
from groups import nightly
from natural import natural

from ringwear import Scene, direct, run

RIPPLES = natural(
    {
        "wear_coefficient": 1.0,
        "profile": {
            "kind": "table",
            "radii": [0.0, 0.2, 0.4, 0.6, 0.8, 1.0],
            "heights": [0.018, 0.012, 0.003, 0.0, 0.004, 0.016],
        },
    },
    [0.0, 1.0, 3000.0],
    load={"normal_force": 5e-4},
)
HUMP = Scene.from_table(
    {
        "units": "SI",
        "punch": {
            "radius": "50 um",
            "rings": 2,
            "wear_coefficient": {
                "radii": ["0 um", "20 um", "20 um", "50 um"],
                "values": [
                    "1e-5 mm^3/(N m)",
                    "2e-5 mm^3/(N m)",
                    "5e-5 mm^3/(N m)",
                    "1e-5 mm^3/(N m)",
                ],
            },
            "profile": {
                "kind": "table",
                "radii": [f"{r} um" for r in (0, 10, 20, 30, 40, 50)],
                "heights": ["900 nm", "600 nm", "150 nm", "0 nm", "200 nm", "800 nm"],
            },
        },
        "half_space": {"youngs_modulus": "70 GPa"},
        "load": {"normal_force": "0.1 N", "sliding_speed": "10 um/s"},
        "wear": {"times": ["0 s", "1e4 s", "1e6 s"]},
        "accuracy": {"rtol": 1e-3},
    }
)


@pytest.mark.slow
@pytest.mark.parametrize("method", [*nightly("mdr"), "fem"])
def test_a_run_in_face_has_the_steady_slope(method):
    # slopes are not promised while edges of the contact move, and a finer march has finer slopes
    result = run(RIPPLES.changed(accuracy__rtol=2e-4), methods=[method])
    uniform = np.array([5e-4 / np.pi])
    steady = direct.rms_slope(np.array([0.0, 1.0]), uniform, "line")
    last = result.dataset.isel(solver=0, time=-1)
    assert float(last.rms_slope) == pytest.approx(float(steady), rel=1e-3)
    # the face is that of the steady state at every radius
    moved = direct.displacement(np.array([0.0, 1.0]), uniform, last.radius.to_numpy())
    heights = last.profile - last.profile.min()
    # errors relative to the displacement, except near the rim, where the slope is infinite
    greatest = direct.greatest_displacement(np.array([0.0, 1.0]), uniform)
    within = last.radius.to_numpy() < 0.99
    np.testing.assert_allclose(heights[within], (greatest - moved)[within], atol=1e-3 * greatest)


@pytest.mark.slow
@pytest.mark.parametrize("method", [*nightly("mdr"), "fem"])
def test_displacements_where_wear_varies_along_the_radius(method):
    data = run(HUMP, methods=[method]).dataset.isel(solver=0, time=-1)
    edges = np.union1d(np.linspace(0, 1, 801), [0.4])
    middles = (edges[1:] + edges[:-1]) / 2
    wear = np.where(middles < 0.4, 1 + middles / 0.4, 5 - 4 * (middles - 0.4) / 0.6)
    # k p is one constant
    pressures = 1 / (np.pi * np.sum(np.diff(edges**2) / wear)) / wear
    greatest = float(direct.greatest_displacement(edges, pressures))
    unit = HUMP.problem.units.displacement
    assert float(data.displacement_max) / unit == pytest.approx(greatest, rel=1e-3)
    # the estimate bounds the error
    off = abs(float(data.displacement_max) / unit - greatest)
    assert off <= float(data.displacement_max_error) * float(data.indentation) / unit


@pytest.mark.slow
def test_the_force_at_a_fixed_indentation_is_decided():
    """Errors are relative to the greatest force so far, because the force itself vanishes."""
    scene = RIPPLES.changed(
        punch__profile={"kind": "parabola", "curvature_radius": 1.0},
        load={"indentation": 0.1},
        wear__times=[0.0, 1.0, 3.0, 10.0, 30.0],
    )
    result = run(scene)
    assert result.verdict == "agree"
    forces = result.dataset.normal_force
    # Hertz
    assert float(forces[0, 0]) == pytest.approx(4 / 3 * 0.1**1.5, rel=1e-6)
    errors = result.dataset.normal_force_error
    assert float(errors.max()) <= 2e-3
    assert float(forces.isel(time=-1).max()) < 1e-3 * float(forces[0, 0])
    # methods differ by at most the sum of their estimates, relative to the greatest force
    between = np.abs(np.diff(forces, axis=0)[0]) / float(forces[0, 0])
    assert (between <= errors.sum("solver").to_numpy() + 1e-12).all()
