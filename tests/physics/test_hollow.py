"""Hollow punches against the flat annulus, and methods against each other."""

import numpy as np
import pytest
from groups import nightly_but
from natural import natural

from ringwear import run
from ringwear.mdr.annulus import flat_annulus


def hollow(inner_radius, methods="mdr fem", rtol=1e-4, times=(0.0, 0.01, 0.1, 1.0), **punch):
    """Return a scene of a hollow punch; without keys of the punch, it has two rings."""
    rings = punch or {"rings": 2, "wear_coefficients": [1.0, 3.0]}
    return natural({"inner_radius": inner_radius, **rings}, times, rtol, methods)


def random_hollow(seed):
    """Return a random scene of a hollow punch."""
    rng = np.random.default_rng(seed)
    inner_radius = float(rng.choice([rng.uniform(0.05, 0.95), 10 ** rng.uniform(-3, -1)]))
    count = int(rng.integers(1, 5))
    widths = rng.uniform(0.3, 1.0, count)
    edges = inner_radius + (1 - inner_radius) * np.cumsum(widths) / widths.sum()
    edges[-1] = 1.0
    wear = (10 ** rng.uniform(-2, 0, count)).tolist()
    punch = {"ring_edges": edges.tolist(), "wear_coefficients": wear}
    times = np.append(0.0, np.sort(10 ** rng.uniform(-4, 1, 4)))
    return hollow(inner_radius, rtol=float(10 ** rng.uniform(-6, -2)), times=times, **punch)


@pytest.mark.parametrize(
    "method", ["mdr", "bem", pytest.param("fem", marks=[pytest.mark.gmsh, pytest.mark.slow])]
)
@pytest.mark.parametrize("inner_radius", [0.1, 0.6, 0.99])
def test_the_flat_start_against_the_flat_annulus(method, inner_radius):
    """The indentation errs by at most 1e-9 by mdr and bem, and 0.1 rtol by finite elements.

    Pressures err by at most rtol, and the estimate is above the error.
    """
    rtol = 1e-4 if method == "fem" else 1e-6
    one = {"rings": 1, "wear_coefficients": [1.0]}
    result = run(hollow(inner_radius, method, rtol, [0.0], **one))
    exact, start = flat_annulus(inner_radius), result.dataset.isel(solver=0, time=0)
    error = abs(float(start.indentation) / exact.indentation - 1)
    assert error <= (0.1 * rtol if method == "fem" else 1e-9)
    assert error <= float(start.indentation_error)
    radii = start.radius.values
    np.testing.assert_allclose(start.pressure, exact.pressure_at(radii), rtol=rtol)


@pytest.mark.slow
@pytest.mark.gmsh
def test_relaxation_times_beside_a_narrow_hole():
    """Elements beside a hole are no wider than half of the face, so that they resolve its modes."""
    result = run(hollow(0.22, rtol=1e-6, wear_coefficient=1.0))
    assert result.verdict == "agree"
    times, errors = (
        result.dataset[name].values[:, :8] for name in ("relaxation_time", "relaxation_time_error")
    )
    assert (errors <= 1e-6).all()
    assert (np.abs(times[1] / times[0] - 1) <= errors.sum(axis=0)).all()


def test_a_small_hole_hardly_changes_the_results():
    """The effect of a hole is of the order of its area."""
    punch = {"ring_edges": [0.5, 1.0], "wear_coefficients": [1.0, 3.0]}
    small, full = (
        run(hollow(inner_radius, "mdr", 1e-7, **punch)).dataset.isel(solver=0)
        for inner_radius in (1e-5, 0.0)
    )
    np.testing.assert_allclose(small.indentation, full.indentation, rtol=2e-7)
    np.testing.assert_allclose(small.relaxation_time[:3], full.relaxation_time[:3], rtol=2e-5)
    np.testing.assert_allclose(small.steady_wear_rate, full.steady_wear_rate, rtol=1e-6)


@pytest.mark.gmsh
def test_a_rotating_pin_reaches_goryachevas_pressure():
    """Goryacheva: the steady pressure is ``p = F / (2 pi (a - b) r)``."""
    inner_radius = 0.4
    rotating = {"wear_coefficient": {"radii": [inner_radius, 1.0], "values": [inner_radius, 1.0]}}
    result = run(hollow(inner_radius, times=[0.0, 10.0], **rotating))
    assert result.verdict == "agree"
    radii = result.dataset.radius.values
    steady = 1 / (2 * np.pi * (1 - inner_radius) * radii)
    for solver in ("mdr", "fem"):
        pressure = result.dataset.pressure.sel(solver=solver).isel(time=-1)
        np.testing.assert_allclose(pressure, steady, rtol=1e-4)
    rate = 1 / (2 * np.pi * (1 - inner_radius))
    np.testing.assert_allclose(result.dataset.steady_wear_rate, rate, rtol=1e-9)


def test_a_flat_hollow_punch_stays_in_full_contact():
    """Pressures stay positive, so full contact can be assumed."""
    times = [0.0, *np.geomspace(1e-4, 3.0, 30).tolist()]
    punch = {"rings": 3, "wear_coefficients": [1e-3, 1.0]}
    pressure = run(hollow(0.3, "mdr", 1e-5, times, **punch)).dataset.pressure
    assert float(pressure.min()) > 0


ALL = "mdr bem direct fem"
TWO = {"rings": 2, "wear_coefficients": [1.0, 3.0]}
HOLLOW = {
    **{f"hole of {hole}": hollow(hole, ALL) for hole in (0.05, 0.5, 0.9)},
    "fixed indentation": hollow(0.4, rtol=1e-3).changed(load={"indentation": 0.7}),
    **{
        f"force from {values}": hollow(0.4, rtol=1e-3).changed(
            load__normal_force={"times": [0.0, 0.5], "values": values}
        )
        for values in ([0.5, 1.0], [1.0, 0.4])
    },
    "recess": hollow(0.4, rtol=1e-3, recess=[0.0, 0.1], **TWO),
    **{
        profile["kind"]: hollow(0.4, rtol=1e-3, profile=profile, **TWO)
        for profile in (
            {"kind": "parabola", "curvature_radius": 1.0},
            {"kind": "rounded_rim", "flat_radius": 0.8, "curvature_radius": 0.5},
            {
                "kind": "table",
                "radii": [0.4, 0.5, 0.7, 0.9, 1.0],
                "heights": [0.1, 0.02, 0.0, 0.02, 0.1],
            },
        )
    },
}


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    "name", nightly_but(("hole of 0.5", "fixed indentation", "recess", "table"), HOLLOW)
)
def test_methods_agree(name):
    result = run(HOLLOW[name])
    assert result.verdict == "agree"
    if HOLLOW[name].problem.full_contact:
        assert not result.summary["left_out_of_promise"]
    indentation = result.dataset.indentation.dropna("solver", how="all")
    np.testing.assert_allclose(indentation[0], indentation[-1], rtol=2e-3)


def test_first_contact_of_a_hollow_sphere_begins_at_its_hole():
    """The contact is an annulus whose outer radius is smaller than that of the face."""
    sphere = {"profile": {"kind": "parabola", "curvature_radius": 0.05}}
    punch = {"rings": 1, "wear_coefficients": [1.0], **sphere}
    start = run(hollow(0.4, "mdr", 1e-3, [0.0], **punch)).dataset.isel(solver=0, time=0)
    assert 0.4 < float(start.contact_radius) < 1.0
    edges = start.contact_edge.values
    assert edges[0] == pytest.approx(0.4, abs=1e-12)
