"""The verdict: methods agree within their stated uncertainty on sensible scenes, and a wrong one is found out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray

from ringwear import Scene, run
from ringwear.studies.crosscheck.agreement import agreements
from ringwear.studies.crosscheck.run import Result
from ringwear.studies.problem.scene import bundled


def disagreements(result: Result) -> list[str]:
    rows = [row for row in result.agreement if not row.agrees]
    return [f"{row.quantity} {row.methods}: {row.difference:.1e} > {row.uncertainty:.1e}" for row in rows]


@pytest.mark.parametrize("mesher", ["gmsh", "bisection"])
@pytest.mark.parametrize("name", bundled())
def test_bundled_scenes_agree(name: str, mesher: str) -> None:
    assert disagreements(run(Scene.load(name).changed(accuracy__fem__mesher=mesher))) == []


@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-5])
def test_five_rings_agree_at_every_accuracy(rtol: float) -> None:
    assert disagreements(run(Scene.load("five_rings").changed(accuracy__rtol=rtol))) == []


@pytest.mark.parametrize(
    "punch",
    [
        {"ring_edges": [0.5, 0.51, 1.0], "wear_coefficients": [10.0, 1.0]},
        {"ring_edges": [0.5, 0.501, 1.0], "wear_coefficients": [1.0, 10.0]},
        {"ring_edges": [0.01, 1.0], "wear_coefficients": [1.0, 10.0]},
        {"ring_edges": [0.99, 1.0], "wear_coefficients": [10.0, 1.0]},
        {"rings": 2, "wear_coefficients": [1.0, 1e4]},
        {"rings": 2, "wear_coefficients": [1e4, 1.0]},
        {"rings": 9, "width_ratio": 10.0, "wear_coefficients": [1.0, 1.001]},
    ],
    ids=str,
)
def test_unusual_punches_agree(punch: dict[str, Any]) -> None:
    scene = Scene.load("five_rings").changed(punch=punch | {"radius": 1.0}, accuracy__rtol=1e-3)
    assert disagreements(run(scene)) == []


@pytest.fixture(scope="module")
def flat() -> Result:
    return run(Scene.load("flat_punch").changed(methods=["mdr", "fem"], accuracy__rtol=1e-3, wear__times=[0.0, 0.1, 1.0]))


def disagreeing(flat: Result, wrong: xarray.Dataset) -> list[str]:
    """Quantities in which the MDR disagrees with wrong finite elements."""
    rows = agreements(("mdr", "fem"), flat.solutions["mdr"].results, wrong, 1e-3)
    return [row.quantity for row in rows if not row.agrees]


@pytest.mark.parametrize("factor", [0.9, 1.1])
@pytest.mark.parametrize(
    "quantity", ["indentation", "displacement_max", "rms_slope", "relaxation_time", "ring_force", "steady_rms_slope"]
)
def test_a_wrong_result_is_noticed(flat: Result, quantity: str, factor: float) -> None:
    right = flat.solutions["fem"].results
    assert disagreeing(flat, right) == []
    wrong = right.assign({quantity: factor * right[quantity]})
    if "time" in right[quantity].dims:
        # at the start slopes are zero, and finite elements state the greatest errors
        wrong, right = wrong.isel(time=[1, 2]), right.isel(time=[1, 2])
        rows = agreements(("mdr", "fem"), flat.solutions["mdr"].results.isel(time=[1, 2]), wrong, 1e-3)
        assert [row.quantity for row in rows if not row.agrees] == [quantity]
    else:
        assert disagreeing(flat, wrong) == [quantity]


def test_one_wrong_time_is_noticed(flat: Result) -> None:
    right = flat.solutions["fem"].results
    assert disagreeing(flat, right.assign(indentation=right.indentation * np.array([1, 1.01, 1]))) == ["indentation"]
