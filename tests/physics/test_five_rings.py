"""The five rings against an independent reference, over the whole history."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray
from wear_reference import exact_results, true_errors

from ringwear import Scene, run

Solve = Callable[..., xarray.Dataset]
Reference = dict[str, Any]
FEM = {"methods": ("fem",), "accuracy__rtol": 1e-4}
MDR = {"methods": ("mdr",), "accuracy__rtol": 1e-6}


@pytest.fixture(scope="module")
def solve(reference: Reference) -> Solve:
    @cache
    def solved(**changes: Any) -> xarray.Dataset:
        lists = {"methods": list(changes.pop("methods")), "output__radii": reference["radii"]}
        times = [state["time"] for state in reference["states"]]
        return run(
            Scene.load("five_rings").changed(wear__times=times, **lists, **changes)
        ).dataset.isel(solver=0)

    return solved


def states(reference: Reference, name: str) -> np.ndarray:
    return np.array([state[name] for state in reference["states"]])


def worst(values: xarray.DataArray, expected: np.ndarray) -> float:
    """Greatest relative difference."""
    return float(np.abs(values.to_numpy() / expected - 1).max())


# with gmsh, and without
MESHERS = [
    pytest.param("quads", marks=pytest.mark.gmsh),
    pytest.param("gmsh", marks=pytest.mark.gmsh),
    "bisection",
]


@pytest.mark.parametrize("average", ["line", "area"])
def test_mdr(solve: Solve, reference: Reference, average: str) -> None:
    found = solve(**MDR, output__gradient_average=average)
    assert worst(found.indentation, states(reference, "indentation")) <= 1e-8
    assert worst(found.displacement_centre, states(reference, "displacement_centre")) <= 1e-5
    assert worst(found.rms_slope, states(reference, f"rms_slope_{average}")) <= 1e-3
    assert worst(found.pressure, states(reference, "pressure")) <= 1e-4
    assert worst(found.profile, states(reference, "profile")) <= 1e-4


@pytest.mark.parametrize("mesher", MESHERS)
def test_fem(solve: Solve, reference: Reference, mesher: str) -> None:
    found = solve(**FEM, accuracy__fem__mesher=mesher)
    assert worst(found.indentation, states(reference, "indentation")) <= 1e-4
    assert worst(found.displacement_centre, states(reference, "displacement_centre")) <= 3e-4
    assert worst(found.pressure, states(reference, "pressure")) <= 1e-2
    assert worst(found.profile, states(reference, "profile")) <= 1e-2


@pytest.mark.parametrize(("scene", "tolerance"), [(MDR, 1e-9), (FEM, 1e-4)], ids=["mdr", "fem"])
def test_relaxation_times(
    solve: Solve, reference: Reference, scene: dict[str, Any], tolerance: float
) -> None:
    expected = np.array(reference["slowest_relaxation_times"])
    assert worst(solve(**scene).relaxation_time[: len(expected)], expected) <= tolerance


def test_ring_forces_against_a_finer_radial_mesh(solve: Solve) -> None:
    finer = solve(
        methods=("mdr",), accuracy__rtol=1e-7, accuracy__mdr__ring_size=1e-6
    ).ring_force.to_numpy()
    assert worst(solve(**MDR).ring_force, finer) <= 1e-5
    # the lightest ring carries a fiftieth of the force: finite elements are held to the whole of it
    assert (
        np.abs(solve(**FEM).ring_force.to_numpy() - finer).max() <= 1e-3 * finer.sum(axis=1).min()
    )


@pytest.mark.parametrize(
    ("scene", "heights", "slopes"),
    [({"methods": ("direct",)}, 1e-12, 1e-10), (MDR, 1e-5, 1e-3), (FEM, 3e-4, 1e-2)],
    ids=["direct", "mdr", "fem"],
)
@pytest.mark.parametrize("average", ["line", "area"])
def test_steady_state(
    solve: Solve,
    reference: Reference,
    scene: dict[str, Any],
    heights: float,
    slopes: float,
    average: str,
) -> None:
    found, steady = solve(**scene, output__gradient_average=average), reference["steady"]
    assert worst(found.steady_displacement_max, np.array(steady["displacement_centre"])) <= heights
    assert worst(found.steady_rms_slope, np.array(steady[f"rms_slope_{average}"])) <= slopes


def test_steady_pressures_in_closed_form(solve: Solve, reference: Reference) -> None:
    """Of the closed form only: the others are handed what Eq. 24 gives."""
    found, steady = solve(methods=("direct",)), reference["steady"]
    assert worst(found.steady_pressure, np.array(steady["ring_pressures"])) <= 1e-12
    assert worst(found.steady_wear_rate, np.array(steady["wear_rate"])) <= 1e-12


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6, 1e-8])
def test_the_dial_of_the_mdr(solve: Solve, reference: Reference, rtol: float) -> None:
    found = solve(methods=("mdr",), accuracy__rtol=rtol)
    assert worst(found.indentation, states(reference, "indentation")) <= rtol
    # slopes converge slowly, but asking for more must not give less
    assert worst(found.steady_rms_slope, np.array(reference["steady"]["rms_slope_line"])) <= max(
        1e-3, rtol
    )


@pytest.mark.parametrize("mesher", MESHERS)
@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-5, pytest.param(1e-8, marks=pytest.mark.slow)])
def test_the_dial_of_the_fem(solve: Solve, reference: Reference, rtol: float, mesher: str) -> None:
    found = solve(methods=("fem",), accuracy__rtol=rtol, accuracy__fem__mesher=mesher)
    assert worst(found.indentation, states(reference, "indentation")) <= rtol


@pytest.mark.gmsh
def test_fem_to_nine_digits(solve: Solve, reference: Reference) -> None:
    """As far as the reference goes; the ring forces against an MDR of the same accuracy."""
    found = solve(methods=("fem",), accuracy__rtol=1e-9)
    assert worst(found.indentation, states(reference, "indentation")) <= 1e-9
    times = np.array(reference["slowest_relaxation_times"])
    assert worst(found.relaxation_time[: len(times)], times) <= 1e-9
    finer = solve(methods=("mdr",), accuracy__rtol=1e-9).ring_force
    assert np.abs(found.ring_force / finer - 1).max() <= 1e-8


@pytest.mark.parametrize(
    "scene",
    [
        *({"methods": ("mdr",), "accuracy__rtol": rtol} for rtol in (1e-3, 1e-5)),
        *({"methods": ("fem",), "accuracy__rtol": rtol} for rtol in (1e-3, 1e-5)),
        *({"methods": ("fem",), "accuracy__fem__degree": degree} for degree in (2, 3, 4)),
        {"methods": ("fem",), "accuracy__fem__poles": 1, "accuracy__fem__truncation": 2.0},
        {"methods": ("fem",), "half_space__poisson_ratio": 0.4999},
    ],
    ids=str,
)
def test_error_estimates_are_honest(
    solve: Solve, reference: Reference, scene: dict[str, Any]
) -> None:
    found, steady = solve(**scene), reference["steady"]
    heights = np.abs(found.indentation / states(reference, "indentation") - 1)
    slope = abs(float(found.steady_rms_slope) / steady["rms_slope_line"] - 1)
    # an estimate, not a bound; the reference itself is known to 1e-10
    assert float((heights / (found.indentation_error + 1e-10)).max()) <= 5
    assert slope <= 5 * float(found.steady_rms_slope_error)


@pytest.mark.gmsh
@pytest.mark.parametrize("rtol", [1e-2, 1e-4, pytest.param(1e-7, marks=pytest.mark.slow)])
def test_the_dial_bounds_every_quantity(reference: Reference, rtol: float) -> None:
    """In its own norm, at every time from the start to beyond the running-in.

    And no estimate is below the truth.
    """
    times = [0.0, *(state["time"] for state in reference["states"])]
    result = run(
        Scene.load("five_rings").changed(
            methods=["mdr", "fem"], wear__times=times, accuracy__rtol=rtol
        )
    )
    assert result.verdict == "agree"
    for errors in true_errors(result).values():
        assert len(errors) == 14
        for quantity, (error, estimate) in errors.items():
            assert error.max() <= rtol, quantity
            assert (error <= estimate).all(), quantity


@pytest.mark.gmsh
@pytest.mark.parametrize("name", ["mdr", "fem"])
def test_profiles_are_as_good_where_little_is_worn(reference: Reference, name: str) -> None:
    """Relative to the greatest height worn, not to the indentation, from t = 0.001 on."""
    times = [state["time"] for state in reference["states"]]
    result = run(
        Scene.load("five_rings").changed(methods=[name], wear__times=times, accuracy__rtol=1e-4)
    )
    exact, found = (
        exact_results(result.scene.problem).profile,
        result.solutions[name].checked.profile,
    )
    assert float((np.abs(found - exact).max("radius") / exact.max("radius")).max()) <= 1e-4
