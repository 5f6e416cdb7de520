"""First contacts that are hard to find: rough faces, many parts and very small loads."""

import time
from itertools import product

import pytest
from closed_forms import PowerPunch
from groups import nightly, nightly_but
from rough_faces import rough, with_heights

from ringwear import run


@pytest.mark.slow
@pytest.mark.parametrize("depth", [1e-12, *nightly(1e-9, 1e-3)])
def test_a_sphere_under_any_indentation(depth):
    """Hertz: ``F = 4/3 sqrt(R) d^1.5``."""
    sphere = {"kind": "parabola", "curvature_radius": 1.0}
    hertz = with_heights([0, 1], [0, 1], indentation=depth).changed(punch__profile=sphere)
    result = run(hertz)
    assert float(result.dataset.normal_force[0, 0]) == pytest.approx(4 / 3 * depth**1.5, rel=1e-7)
    assert result.verdict != "disagree"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("exponent", "force"),
    nightly_but(
        [(1.0, 1e-22), (2.0, 1e-30), (4.0, 1e-12)],
        product([1.0, 2.0, 4.0], [1e-30, 1e-22, 1e-12]),
    ),
)
def test_any_punch_under_any_force(exponent, force):
    exact = PowerPunch(0.5, exponent)
    power = {"kind": "power", "coefficient": 0.5, "exponent": exponent}
    wear = {"times": [0.0], "steady": False}
    scene = with_heights([0, 1], [0, 1], normal_force=force)
    scene = scene.changed(punch__profile=power, wear=wear)
    start = run(scene).dataset.isel(solver=0, time=0)
    radius = exact.contact_radius(force)
    assert float(start.indentation) == pytest.approx(exact.indentation(radius), rel=1e-7, abs=0)
    assert float(start.contact_radius) == pytest.approx(radius, rel=1e-6, abs=0)


@pytest.mark.slow
def test_a_start_of_many_parts_against_a_fitted_mesh():
    began = time.process_time()
    result = run(rough(20, normal_force=0.1))
    assert time.process_time() - began < 10
    assert any("the start cannot be fitted" in note for note in result.notes)
    data = result.dataset.isel(solver=0, time=0)
    assert float(data.ring_force.sum()) == pytest.approx(0.1, rel=1e-9)
    # indentation on a mesh that was fitted to the contact edges
    assert float(data.indentation) == pytest.approx(
        0.083289092068, rel=float(data.indentation_error)
    )
    assert float(data.indentation_error) < 1e-3
