"""The map of limits: its oracles against identities, its verdicts, and that every family can be asked for."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ringwear.mdr import direct
from ringwear.meshes.errors import SolverError
from ringwear.meshes.radial import alternating_edges
from ringwear.studies.convergence.levels import Table
from ringwear.studies.extremes import study as extremes
from ringwear.studies.extremes.cells import all_cells
from ringwear.studies.extremes.reference import Rings, units
from ringwear.studies.extremes.study import Judge, conclude, draw, verdict
from ringwear.studies.progress import silent

from ringwear import Scene

FIVE = Scene.load("five_rings")


@pytest.mark.parametrize("edges", [alternating_edges(1), alternating_edges(5), alternating_edges(4, 3.0)])
def test_carlsons_integrals_agree_with_legendres(edges: np.ndarray) -> None:
    wear = np.where(np.arange(len(edges) - 1) % 2, 0.1, 1.0)
    pressures = direct.steady_pressures(edges, wear)
    rings = Rings(edges)
    assert rings.greatest_displacement(wear) == pytest.approx(direct.greatest_displacement(edges, pressures), rel=1e-12)
    for average in ("line", "area"):
        assert rings.rms_slope(wear, average) == pytest.approx(direct.rms_slope(edges, pressures, average), rel=3e-10)


def test_the_oracle_knows_the_homogeneous_punch() -> None:
    rings, one = Rings(alternating_edges(1)), np.ones(1)
    mean = 1 / np.pi
    assert rings.greatest_displacement(one) == pytest.approx(2 * mean, rel=1e-13)
    assert rings.rms_slope(one, "area") == pytest.approx(4 / np.pi * mean, rel=1e-9)
    assert float(rings.late_indentation(one, np.zeros(1))[0]) == pytest.approx(16 / (3 * np.pi**2), rel=1e-9)


def test_units_are_exact_where_doubles_would_overflow() -> None:
    scene = FIVE.changed(load={"normal_force": 1e300, "sliding_speed": 1.0}, punch__radius=1e-9)
    with pytest.raises(OverflowError):
        units(scene.changed(half_space={"youngs_modulus": 1e-9}))
    assert units(FIVE)["displacement"] == 2.0


@pytest.mark.parametrize(
    ("error", "estimate", "expected"),
    [
        (1e-4, 2e-4, "within"),
        (0.05, 0.1, "degraded"),
        (5e-4, 1e-6, "degraded"),
        (2e-3, 1e-3, "degraded"),
        (0.1, 1e-3, "wrong"),
    ],
)
def test_verdicts(error: float, estimate: float, expected: str) -> None:
    assert verdict(error, estimate, 1e-3) == expected


def test_the_map_has_more_than_two_thousand_cells_and_every_table_is_unique() -> None:
    cells = list(all_cells(FIVE, False))
    assert len(cells) >= 2000
    assert {"direct", "mdr", "fem"} == {cell.method for cell in cells}
    places = [(cell.family, cell.method, cell.x, cell.y) for cell in cells]
    assert len(set(places)) == len(places)
    assert 200 <= len(list(all_cells(FIVE, True))) < 600


def test_a_quick_cell_of_each_family_and_method_is_judged(tmp_path: Path) -> None:
    chosen = {}
    for cell in all_cells(FIVE, True):
        # a time in between asks the oracle for the other method at 1e-6: one such cell is enough
        between = 1.0 in cell.table["wear"]["times"]
        if cell.family == "rtol × rings" or not between:
            chosen.setdefault((cell.family, cell.method), cell)
    judge = Judge()
    rows = [judge.row(cell) for cell in chosen.values()]
    assert not [row for row in rows if row["verdict"] == "crashed"]
    draw(rows, tmp_path / "extremes.png")
    assert (tmp_path / "extremes.png").stat().st_size > 10_000
    assert conclude(rows)[0].startswith(f"{len(rows)} cells")


@pytest.mark.parametrize(
    ("family", "x", "y"),
    [
        # the layer of these is set by the width of the ring, not by the size asked for
        *(("rim_size/a × degree", 0.5, degree) for degree in (8, 12, 16)),
        *(("ring_size/a × degree", 0.5, degree) for degree in (4, 12, 16)),
        ("h2/h1 × k2/k1", 0.01, 1e-8),
        # relaxation times span more than the digits of an eigenvalue
        ("ring width/a × k2/k1", 1e-9, 1e8),
    ],
)
def test_estimates_hold_where_rings_limit_the_mesh(family: str, x: float, y: float) -> None:
    (cell,) = (c for c in all_cells(FIVE, False) if (c.family, c.method, c.x, c.y) == (family, "mdr", x, y))
    row = Judge().row(cell)
    assert row["error"] <= row["estimate"]


def test_the_oracle_knows_what_cancels_over_a_narrow_ring_of_high_pressure() -> None:
    place = ("ring width/a × k2/k1", "direct", 1e-9, 1e-8)
    (cell,) = (c for c in all_cells(FIVE, False) if (c.family, c.method, c.x, c.y) == place)
    assert Judge().row(cell)["verdict"] == "within"


def test_scenes_of_other_times_share_no_finite_elements() -> None:
    """Their sizes follow the first time asked for."""
    judge, scene = Judge(), FIVE.changed(accuracy__rtol=1e-4, accuracy__fem__mesher="bisection")
    units = scene.natural.time
    early, late = (scene.changed(wear__times=[time * units]).natural for time in (1e-6, 1e3))
    assert judge.model(early, "fem").unknowns > judge.model(late, "fem").unknowns
    assert judge.model(early, "fem") is judge.model(early, "fem")


def test_refusals_and_crashes_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = next(iter(all_cells(FIVE, True)))

    def raising(error: Exception) -> Any:
        def judgements(*_: Any) -> Any:
            raise error

        return judgements

    for error, expected in ((SolverError("no"), "refused"), (ZeroDivisionError("oh"), "crashed")):
        monkeypatch.setattr(Judge, "judgements", raising(error))
        assert Judge().row(cell)["verdict"] == expected


def test_finished_rows_are_kept_when_interrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cells = list(all_cells(FIVE, True))[:3]
    monkeypatch.setattr(extremes, "all_cells", lambda *_: iter(cells))
    judge, asked = Judge.row, []

    def row(self: Judge, cell: Any) -> dict[str, Any]:
        asked.append(cell)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return judge(self, cell)

    monkeypatch.setattr(Judge, "row", row)
    conclusions = extremes.conduct(FIVE, tmp_path, argparse.Namespace(quick=True), silent)
    assert conclusions[0].startswith("INTERRUPTED")
    with (tmp_path / "extremes.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 2
    assert isinstance(extremes._limits([], tmp_path), Table)
