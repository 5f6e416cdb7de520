"""The independent reference that estimates are judged by is judged itself.

By closed forms and by numbers from elsewhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ringwear import Scene
from ringwear.mdr import direct
from ringwear.studies.estimates.reference import Reference, known

EDGES = np.array([0.0, 0.2, 0.5, 0.55, 1.0])
WEAR = np.array([1.0, 0.1, 1.0, 0.3])


@pytest.fixture(scope="module")
def five(reference: dict[str, Any]) -> tuple[Reference, NDArray[np.float64]]:
    wear = np.array(reference["wear_coefficients"])
    times = np.array([state["time"] for state in reference["states"]]) * wear.max()
    return Reference(np.array(reference["ring_edges"]), wear / wear.max(), np.full(5, 1e-13)), times


def test_history_of_five_rings(
    five: tuple[Reference, NDArray[np.float64]], reference: dict[str, Any]
) -> None:
    punch, times = five
    pressure, worn, indentation = punch.at(times)
    force, radii = reference["normal_force"], np.array(reference["radii"])

    def states(name: str) -> NDArray[np.float64]:
        return np.array([state[name] for state in reference["states"]]) / force

    np.testing.assert_allclose(indentation, states("indentation"), rtol=1e-10)
    np.testing.assert_allclose(punch.values(pressure, radii)[3:], states("pressure")[3:], rtol=2e-6)
    np.testing.assert_allclose(punch.worn(worn, radii)[3:], states("profile")[3:], rtol=2e-6)
    for average in ("line", "area"):
        np.testing.assert_allclose(
            punch.rms_slopes(worn, average)[3:], states(f"rms_slope_{average}")[3:], rtol=1e-5
        )
    centre = indentation - punch.worn(worn, np.zeros(1))[:, 0]
    np.testing.assert_allclose(centre, states("displacement_centre"), rtol=1e-9)
    expected = np.array(reference["slowest_relaxation_times"]) * max(reference["wear_coefficients"])
    np.testing.assert_allclose(punch.relaxation_times[: len(expected)], expected, rtol=1e-10)


def test_late_it_is_the_steady_state_in_closed_form() -> None:
    punch = Reference(EDGES, WEAR, np.full(4, 1e-13))
    pressures = direct.steady_pressures(EDGES, WEAR)
    assert punch.wear_rate == pytest.approx(WEAR[0] * pressures[0], rel=1e-12)
    pressure, worn, indentation = punch.at(np.array([1e3]))
    middle = (EDGES[1:] + EDGES[:-1]) / 2
    np.testing.assert_allclose(punch.values(pressure, middle)[0], pressures, rtol=1e-11)
    displacement = indentation[0] - punch.worn(worn, middle)[0]
    np.testing.assert_allclose(
        displacement, direct.displacement(EDGES, pressures, middle), rtol=1e-10
    )
    assert punch.greatest(worn, indentation)[0] == pytest.approx(
        direct.greatest_displacement(EDGES, pressures), rel=1e-9
    )
    for average in ("line", "area"):
        assert punch.rms_slopes(worn, average)[0] == pytest.approx(
            direct.rms_slope(EDGES, pressures, average), rel=1e-7
        )


def test_forces_and_worn_volumes_add_up() -> None:
    punch, times = Reference(EDGES, WEAR, np.full(4, 1e-12)), np.array([1e-6, 1e-3, 1.0])
    pressure, _, _ = punch.at(times)
    np.testing.assert_allclose(punch.ring_forces(pressure).sum(axis=1), 1, rtol=1e-13)


def test_it_gives_all_that_a_problem_asks_for() -> None:
    problem = Scene.load("five_rings").problem
    found = known(problem)
    assert (found.sizes["time"], found.sizes["radius"]) == (
        len(problem.checked),
        len(problem.face.radii),
    )
    assert not any(bool(np.isnan(found[name]).any()) for name in found.data_vars)
    assert float(found.indentation[0]) == 0.5
    assert not found.profile[0].any()
