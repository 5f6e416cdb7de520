"""The map of limits.

Its reference solution against identities, its verdicts, and that every family can be asked for.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ringwear.mdr import direct
from ringwear.meshes.radial import alternating_edges
from ringwear.studies.numerics import extremes
from ringwear.studies.numerics.extremes import Cell, list_cells
from ringwear.studies.numerics.steady_rings import SteadyRings

ALL, QUICK = (list(list_cells(0.3, quick)) for quick in (False, True))


def cell(*place: float | str) -> Cell:
    """The cell of a family and a method, at x and y."""
    (chosen,) = (cell for cell in ALL if cell[:4] == place)
    return chosen


@pytest.mark.parametrize(
    "edges", [alternating_edges(1), alternating_edges(5), alternating_edges(4, 3.0)]
)
def test_carlsons_integrals_agree_with_legendres(edges: np.ndarray) -> None:
    wear = np.where(np.arange(len(edges) - 1) % 2, 0.1, 1.0)
    pressures, rings = direct.steady_pressures(edges, wear), SteadyRings(edges)
    by_pattern = rings.pressures(wear)
    greatest = direct.greatest_displacement(edges, pressures)
    assert rings.greatest_displacement(by_pattern) == pytest.approx(greatest, rel=1e-12)
    slope = np.sqrt(by_pattern @ rings.grams[0] @ by_pattern)
    assert slope == pytest.approx(direct.rms_slope(edges, pressures, "line"), rel=3e-10)


def test_the_reference_solution_has_the_homogeneous_punch() -> None:
    rings, mean = SteadyRings(alternating_edges(1)), 1 / np.pi
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
    assert extremes.verdict_on("indentation", error, estimate, 1e-3)["verdict"] == verdict


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
    rows = [extremes.judge(cell) for cell in chosen.values()]
    assert not {"wrong", "crashed"} & {row["verdict"] for row in rows}
    assert len(extremes.tabulate_limits(rows, tmp_path / "limits.csv").rows) == len(rows)
    extremes.draw(rows, tmp_path / "extremes.png")
    assert (tmp_path / "extremes.png").exists()


NARROW = "h2/h1 of 3 rings × k2/k1", 2.1e-9


@pytest.mark.parametrize(
    "place",
    [
        # the layer of these is set by the width of the ring, not by the size asked for
        *(("rim_size/a × degree", 0.5, degree) for degree in (8, 12, 16)),
        *(("ring_size/a × degree", 0.5, degree) for degree in (4, 12, 16)),
        ("h2/h1 × k2/k1", 0.01, 1e-8),
        # relaxation times span more than the digits of an eigenvalue
        (*NARROW, 1e8),
    ],
)
def test_estimates_hold_where_rings_limit_the_mesh(place: tuple[str, float, float]) -> None:
    row = extremes.judge(cell(place[0], "mdr", *place[1:]))
    assert row["error"] <= row["estimate"]


def test_the_reference_allows_for_what_cancels_over_a_narrow_ring_of_high_pressure() -> None:
    family, width = NARROW
    assert extremes.judge(cell(family, "direct", width, 1e-8))["verdict"] == "within"


def test_refusals_are_not_crashes() -> None:
    unstable = extremes.judge(cell("step × march", "mdr", 100.0, "explicit"))
    assert unstable["verdict"] == "refused"
    assert "unstable" in unstable["message"]
    assert extremes.judge(QUICK[0]._replace(method="unheard of"))["verdict"] == "crashed"
