"""The verdict.

Methods agree within their stated uncertainty on sensible scenes, and a wrong one is found out.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray

from ringwear import Scene, run
from ringwear.studies.crosscheck.agreement import Agreement, agreements, overall
from ringwear.studies.crosscheck.run import Result
from ringwear.studies.problem.scene import bundled

FLAT = [name for name in bundled() if Scene.load(name).problem.full_contact]


def disagreements(result: Result) -> list[str]:
    rows = [row for row in result.agreement if row.verdict == "disagree"]
    wrong = [
        f"{row.quantity} {row.methods}: {row.difference:.1e} > {row.uncertainty:.1e}"
        for row in rows
    ]
    return wrong + [
        f"{one.method}: {one.name} {one.difference:.1e}" for one in result.anchors if not one.holds
    ]


def undecided(result: Result) -> set[str]:
    return {row.quantity for row in result.agreement if row.verdict == "undecided"}


@pytest.mark.parametrize(
    "mesher",
    [
        pytest.param("quads", marks=pytest.mark.gmsh),
        pytest.param("gmsh", marks=pytest.mark.slow),
        "bisection",
    ],
)
@pytest.mark.parametrize("name", FLAT)
def test_bundled_scenes_agree(name: str, mesher: str) -> None:
    result = run(Scene.load(name).changed(accuracy__fem__mesher=mesher))
    assert disagreements(result) == []
    if mesher == "quads":
        # fields of 32 rings are resolved as far as is affordable, and it is said how far
        fields = {"pressure", "rms_slope", "steady_rms_slope"}
        assert undecided(result) <= (fields if name == "many_rings" else set())
        assert all(
            "so many rings" in row.remark for row in result.agreement if row.verdict == "undecided"
        )


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("name", [one for one in bundled() if one not in FLAT])
def test_bundled_scenes_of_any_punch_agree(name: str) -> None:
    result = run(Scene.load(name))
    assert disagreements(result) == []
    # beside edges that move fields are known to a cell
    assert not undecided(result) & {"indentation", "normal_force"}


@pytest.mark.gmsh
@pytest.mark.parametrize("rtol", [1e-2, 1e-3, pytest.param(1e-5, marks=pytest.mark.slow)])
def test_five_rings_agree_at_every_accuracy(rtol: float) -> None:
    result = run(Scene.load("five_rings").changed(accuracy__rtol=rtol))
    assert disagreements(result) == []
    assert result.verdict == "agree"
    assert result.verdict_in_words == "The methods agree: 14 of 14 quantities agree."


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
    return run(
        Scene.load("flat_punch").changed(
            methods=["mdr", "fem"], accuracy__rtol=1e-3, wear__times=[0.0, 0.1, 1.0]
        )
    )


def compared(
    flat: Result, wrong: xarray.Dataset, errors: dict[str, Any] | None = None
) -> list[Agreement]:
    """The MDR against finite elements with other results, or other errors."""
    mdr, fem = flat.solutions["mdr"], flat.solutions["fem"]
    changed = replace(fem, checked=wrong, errors=fem.errors | (errors or {}))
    return agreements(flat.scene.problem, ("mdr", "fem"), (mdr, changed))


def with_verdict(rows: list[Agreement], verdict: str) -> list[str]:
    return [row.quantity for row in rows if row.verdict == verdict]


@pytest.mark.parametrize("factor", [0.98, 1.02])
@pytest.mark.parametrize(
    "quantity",
    [
        "pressure",
        "profile",
        "displacement",
        "displacement_centre",
        "displacement_max",
        "rms_slope",
        "relaxation_time",
        "ring_force",
        "steady_pressure",
        "steady_profile",
        "steady_rms_slope",
        "steady_wear_rate",
    ],
)
def test_a_wrong_result_is_noticed(flat: Result, quantity: str, factor: float) -> None:
    right = flat.solutions["fem"].checked
    assert with_verdict(compared(flat, right), "disagree") == []
    wrong = right.assign({quantity: factor * right[quantity]})
    assert with_verdict(compared(flat, wrong), "disagree") == [quantity]


def test_one_wrong_time_is_noticed(flat: Result) -> None:
    right = flat.solutions["fem"].checked
    (row,) = [
        row
        for row in compared(
            flat, right.assign(indentation=right.indentation * np.array([1, 1.01, 1]))
        )
        if row.verdict == "disagree" and row.quantity == "indentation"
    ]
    assert row.difference == pytest.approx(0.01, rel=0.02)


def test_what_a_method_does_not_know_is_undecided_not_agreed(flat: Result) -> None:
    """An uncertainty above what was asked for excuses no difference, and hides none."""
    right = flat.solutions["fem"].checked
    unsure = {"profile": np.array([1e-5, 0.2, 1e-5])}
    (row,) = [row for row in compared(flat, right, unsure) if row.quantity == "profile"]
    assert row.verdict == "undecided"
    assert row.uncertainty == pytest.approx(0.2, rel=0.01)
    assert row.remark.startswith("at 1 of 3 times: fem states 2.0e-01")
    wrong = right.assign(profile=1.5 * right.profile)
    (row,) = [row for row in compared(flat, wrong, unsure) if row.quantity == "profile"]
    assert row.verdict == "disagree"


def test_what_is_local_to_moving_edges_decides_against_only() -> None:
    rows = [
        Agreement("indentation", ("mdr", "fem"), 1e-5, 1e-4, "agree"),
        Agreement("pressure", ("mdr", "fem"), 1e-2, 1e-1, "undecided", promised=False),
    ]
    assert overall(tuple(rows)) == "agree"
    assert overall((replace(rows[0], verdict="undecided"), rows[1])) == "undecided"
    assert overall((rows[0], replace(rows[1], verdict="disagree"))) == "disagree"


@pytest.mark.gmsh
def test_early_layers_that_cannot_be_resolved_are_named() -> None:
    """As t tends to zero the slope is that of a layer at the rim ever thinner."""
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"], accuracy__rtol=1e-6, wear__times=[1e-10, 0.1]
    )
    result = run(scene)
    assert disagreements(result) == []
    (row,) = [row for row in result.agreement if row.quantity == "rms_slope"]
    assert row.verdict == "undecided"
    assert row.remark.startswith("at t = 1e-10: the layers that wear makes")
    # slopes of layers thinner than coordinates can tell are not promised
    assert not row.promised
    assert result.verdict == "agree"
    # the early time does not spoil the later one
    assert result.solutions["mdr"].errors["rms_slope"][1] < 1e-6
