"""Results of every load have the same quantities."""

import numpy as np
import pytest
from loads import LOADS, pressed_by

from ringwear import Scene, run


@pytest.fixture(scope="module")
def sphere():
    return run(Scene.load("sphere").changed(wear__times=[0.0, 0.1]), methods=["mdr"], rtol=1e-2)


@pytest.mark.parametrize("name", LOADS)
def test_results_of_every_load_have_the_same_quantities(name, sphere):
    result = run(pressed_by(**LOADS[name]), methods=["mdr"], rtol=1e-2)
    data = result.dataset.isel(solver=0)
    assert set(data) == set(sphere.dataset)
    for quantity, values in data.items():
        is_error = str(quantity).endswith("_error")
        if values.dims[:1] == ("time",) and quantity != "contact_edge" and not is_error:
            # pressures of a flat punch are infinite at its rim at the start
            assert np.isfinite(values[1:]).all(), quantity
    # only a punch that loses contact has no relaxation modes
    assert data.relaxation_time.isnull().all() == (name == "falling")
    assert result.verdict != "disagree"


def test_a_flat_punch_has_the_contact_of_its_face():
    scene = Scene.load("flat_punch").changed(punch__radius=2.0, load__normal_force=3.0)
    result = run(scene, methods=["mdr"])
    data, answer = result.dataset.isel(solver=0), result.answers["mdr"]
    assert data.contact_radius.values == pytest.approx(2.0)
    assert data.normal_force.values == pytest.approx(3.0, rel=1e-6)
    assert data.contact.values.all()
    np.testing.assert_allclose(data.contact_edge.values, [[0.0, 2.0]] * data.sizes["time"])
    assert answer["contact_radius_start"] == pytest.approx(2.0)
    assert answer["time_to_full_contact"] == 0
    # the force is that of the load, and the volume is k times its work
    assert [answer["force_start"], answer["force_end"]] == pytest.approx([3.0, 3.0], rel=1e-6)
    wear = scene.problem.units.wear_coefficient
    work = 3.0 * data.time.values * wear
    np.testing.assert_allclose(data.ring_worn_volume.values[:, 0], work, rtol=1e-6, atol=1e-12)
