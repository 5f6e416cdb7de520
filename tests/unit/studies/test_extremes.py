"""The map of limits.

Its reference solution against identities, its verdicts, and that every family can be asked for.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ringwear import Scene
from ringwear.mdr import direct
from ringwear.meshes.radial import alternating_edges
from ringwear.studies.extremes import study
from ringwear.studies.extremes.cells import Cell, all_cells
from ringwear.studies.extremes.map import draw, limits
from ringwear.studies.extremes.reference import Reference
from ringwear.studies.problem.sections import FemAccuracy

FIVE = Scene.load("five_rings")
ALL, QUICK = (list(all_cells(0.3, quick)) for quick in (False, True))


def cell(family: str, method: str, x: float, y: float | str) -> Cell:
    (one,) = (cell for cell in ALL if cell[:4] == (family, method, x, y))
    return one


@pytest.mark.parametrize(
    "edges", [alternating_edges(1), alternating_edges(5), alternating_edges(4, 3.0)]
)
def test_carlsons_integrals_agree_with_legendres(edges: np.ndarray) -> None:
    wear = np.where(np.arange(len(edges) - 1) % 2, 0.1, 1.0)
    pressures, rings = direct.steady_pressures(edges, wear), Reference(edges)
    by_pattern = rings.pressures(wear)
    assert rings.greatest_displacement(by_pattern) == pytest.approx(
        direct.greatest_displacement(edges, pressures), rel=1e-12
    )
    slope = np.sqrt(by_pattern @ rings.grams[0] @ by_pattern)
    assert slope == pytest.approx(direct.rms_slope(edges, pressures, "line"), rel=3e-10)


def test_the_reference_solution_has_the_homogeneous_punch() -> None:
    rings, mean = Reference(alternating_edges(1)), 1 / np.pi
    pressures = rings.pressures(np.ones(1))
    assert rings.greatest_displacement(pressures) == pytest.approx(2 * mean, rel=1e-13)
    assert pressures @ rings.grams[1] @ pressures == pytest.approx(16 / (3 * np.pi**2), rel=1e-9)


@pytest.mark.parametrize(
    ("error", "estimate", "verdict"),
    [
        (1e-4, 2e-4, "within"),
        (0.05, 0.1, "degraded"),
        (5e-4, 1e-6, "degraded"),
        (2e-3, 1e-3, "degraded"),
        (0.1, 1e-3, "wrong"),
        (np.nan, 1e-3, "wrong"),
    ],
)
def test_verdicts(error: float, estimate: float, verdict: str) -> None:
    assert study.judged("indentation", error, estimate, 1e-3)["verdict"] == verdict


def test_every_method_has_its_cells_and_no_cell_comes_twice() -> None:
    assert {"direct", "mdr", "fem"} == {cell.method for cell in ALL}
    for cells in (ALL, QUICK):
        assert len({cell[:4] for cell in cells}) == len(cells)
    assert {cell.family for cell in QUICK} == {cell.family for cell in ALL}
    assert len(ALL) > 2000 > 600 > len(QUICK)


def test_a_quick_cell_of_each_family_and_method_is_judged(tmp_path: Path) -> None:
    # a time in between asks for the other method at 1e-6: one such family is enough
    ready = (
        cell for cell in QUICK if cell.family == "rtol × rings" or 1.0 not in cell.scene.wear.times
    )
    chosen = {(cell.family, cell.method): cell for cell in ready}
    rows = [study.row(cell) for cell in chosen.values()]
    assert not {"wrong", "crashed"} & {row["verdict"] for row in rows}
    assert len(limits(rows, tmp_path / "limits.csv").rows) == len(rows)
    draw(rows, tmp_path / "extremes.png")
    assert (tmp_path / "extremes.png").exists()


@pytest.mark.parametrize(
    "place",
    [
        # the layer of these is set by the width of the ring, not by the size asked for
        *(("rim_size/a × degree", 0.5, degree) for degree in (8, 12, 16)),
        *(("ring_size/a × degree", 0.5, degree) for degree in (4, 12, 16)),
        ("h2/h1 × k2/k1", 0.01, 1e-8),
        # relaxation times span more than the digits of an eigenvalue
        ("ring width/a × k2/k1", 1e-9, 1e8),
    ],
)
def test_estimates_hold_where_rings_limit_the_mesh(place: tuple[str, float, float]) -> None:
    family, x, y = place
    row = study.row(cell(family, "mdr", x, y))
    assert row["error"] <= row["estimate"]


def test_the_reference_allows_for_what_cancels_over_a_narrow_ring_of_high_pressure() -> None:
    assert study.row(cell("ring width/a × k2/k1", "direct", 1e-9, 1e-8))["verdict"] == "within"


def test_finite_elements_are_shared_by_scenes_of_other_loads_but_not_of_other_times_or_wear() -> (
    None
):
    """Their sizes follow what wear has blunted by the first time asked for."""
    problem = replace(FIVE.problem, fem=FemAccuracy(mesher="bisection"))
    early, late = (
        study.discretised(replace(problem, times=np.array([time])), "fem", coarser=False)
        for time in (1e-6, 1e3)
    )
    assert early.unknowns > late.unknowns
    longer = replace(problem, times=np.array([1e3, 1e4]))
    assert study.discretise(longer, "fem") is late
    rings = problem.rings._replace(wear_coefficients=problem.wear_coefficients**2)
    assert study.discretise(replace(longer, rings=rings), "fem") is not late


def test_refusals_are_not_crashes() -> None:
    unstable = study.row(cell("step × march", "mdr", 100.0, "explicit"))
    assert unstable["verdict"] == "refused"
    assert "unstable" in unstable["message"]
    assert study.row(QUICK[0]._replace(method="unheard of"))["verdict"] == "crashed"
