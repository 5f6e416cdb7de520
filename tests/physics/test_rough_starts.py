"""First contacts that are hard to find: rough faces, many parts and very small loads."""

import time

import pytest
from groups import nightly
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


@pytest.mark.slow
def test_a_face_too_rough_for_the_cells_states_a_large_error():
    result = run(rough(200, normal_force=1e-2))
    assert float(result.dataset.indentation_error.max()) > 0.1
    assert result.short_of["mdr"] > 0.1
