"""The studies: the machinery of orders against exact sequences, and the quick version of each study."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from meshes.errors import SolverError
from meshes.half_space import SizeField
from studies import Scene, compare, convergence, march, truncation
from studies.levels import LEVEL_FIELDS, Recorder, Sequence, Table, between, extrapolated, keeping_rows, least_squares
from studies.levels import order_of_three as of_three
from studies.stages import silent

SIZES = np.array([0.5, 0.3, 0.2, 0.1])


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def conducted(study: Any, out: Path, **changes: Any) -> list[str]:
    lines = study.conduct(Scene.load("five_rings").changed(**changes), out, argparse.Namespace(quick=True), silent)
    pictures = list(out.glob("*.png"))
    assert pictures
    assert all(picture.stat().st_size > 10_000 for picture in pictures)
    assert len(list(out.glob("*.md"))) == 1
    return list(lines)


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 7.5])
@pytest.mark.parametrize("sign", [1, -1])
def test_orders_of_an_exact_sequence(order: float, sign: int) -> None:
    errors = sign * 0.3 * SIZES**order
    assert between(SIZES, errors) == pytest.approx(order)
    assert least_squares(SIZES, errors) == pytest.approx(order)
    assert of_three(SIZES[:3], 2 + errors[:3]) == pytest.approx(order, abs=1e-6)
    limit = extrapolated(SIZES, 2 + errors, order)
    assert limit.value == pytest.approx(2, abs=1e-9)
    assert limit.gci == pytest.approx(1.25 * abs(errors[-1]) / abs(2 + errors[-1]), rel=1e-5)
    assert limit.asymptotic


def test_sequences_that_do_not_converge_are_called_so() -> None:
    oscillating = extrapolated(SIZES, np.array([1.0, 1.1, 0.9, 1.05]))
    assert not oscillating.asymptotic
    assert np.isnan(oscillating.gci)
    assert oscillating.value == 1.05
    assert not extrapolated(SIZES, 1 + SIZES, expected=4.0).asymptotic
    assert not extrapolated(SIZES[:2], 1 + SIZES[:2]).asymptotic


def test_the_floor_is_left_out_of_least_squares() -> None:
    sequence = Sequence("h", "value", 2.0, exact=1.0, floor=0.05)
    for size in SIZES:
        sequence.add(size, 1 + max(size**2, 0.045))
    assert sequence.order == pytest.approx(2)
    assert sequence.summary()["levels"] == "2 of 4"


def test_rows_are_on_disk_at_once_and_kept_on_interruption(tmp_path: Path) -> None:
    table, conclusions = Table(tmp_path / "t.csv", ("a", "b")), []
    with keeping_rows(conclusions):
        table.add(a=1, b="x")
        assert rows(tmp_path / "t.csv") == [{"a": "1", "b": "x"}]
        raise KeyboardInterrupt
    assert "INTERRUPTED" in conclusions[0]


def test_a_level_that_fails_is_a_row(tmp_path: Path) -> None:
    recorder = Recorder(Table(tmp_path / "t.csv", LEVEL_FIELDS), {}, {}, silent)

    def fails() -> tuple[dict[str, float], int]:
        raise SolverError("singular")

    recorder.level("h", 0.1, {}, fails, 0.0)
    assert rows(tmp_path / "t.csv")[0]["remark"] == "failed: singular"


@pytest.mark.parametrize("count", [1, 2, 3])
def test_subdivision(count: int) -> None:
    from meshes import bisection

    base = bisection.mesh(SizeField((0.0, 0.4, 1.0), 1e-5, 1e-4, 0.8, 20.0))
    fine = convergence.subdivided(base, count, np.array([0.4, 1.0]))
    assert len(fine.triangles) == count**2 * len(base.triangles)
    # points put on the arc cost the triangles beside it some of their shape
    assert fine.quality.min() > 0.7 * base.quality.min()
    # every vertex of the base is kept, and the arc is an arc
    assert np.isin(base.contact_radii, fine.contact_radii).all()
    far = fine.points[np.unique(fine.boundaries["far"])]
    assert np.hypot(*far.T) == pytest.approx(20.0, rel=1e-12)


def test_convergence(tmp_path: Path) -> None:
    conducted(convergence, tmp_path)
    order = {(r["refined"], r["quantity"]): float(r["least squares"]) for r in rows(tmp_path / "orders.csv")}
    for degree, theory in ((2, 4), (3, 6), (4, 8)):
        assert order[f"FEM P{degree}, graded", "d0"] == pytest.approx(theory, abs=0.2)
        assert order[f"FEM P{degree}, uniform", "d0"] == pytest.approx(1, abs=0.2)
    assert order["MDR degree 1, graded", "d0"] == pytest.approx(5, abs=0.3)
    assert order["MDR degree 1, graded", "slowest relaxation time"] == pytest.approx(4, abs=0.3)


def test_truncation(tmp_path: Path) -> None:
    conducted(truncation, tmp_path)
    found = {r["far field"]: r["least squares"] for r in rows(tmp_path / "orders.csv") if r["nu"] == "0.3"}
    assert float(found["fixed"]) == pytest.approx(1, abs=0.1)
    assert float(found["1 pole"]) == pytest.approx(5, abs=0.3)
    assert float(found["2 poles"]) == pytest.approx(9, abs=0.6)


def test_march(tmp_path: Path) -> None:
    conducted(march, tmp_path)
    for row in rows(tmp_path / "orders.csv"):
        assert float(row["least squares"]) == pytest.approx(1, abs=0.03)
    for row in rows(tmp_path / "limits.csv"):
        exact = row["theory"] != "4/(pi n k)"
        assert float(row["found over theory"]) == pytest.approx(1, abs=0.02 if exact else 0.15)


def test_compare(tmp_path: Path) -> None:
    lines = conducted(compare, tmp_path)
    assert {r["methods"] for r in rows(tmp_path / "compare.csv")} >= {"mdr - fem", "mdr - direct", "mdr - bem"}
    assert all(r["agrees"] == "True" for r in rows(tmp_path / "compare.csv"))
    assert not any("BEYOND" in line for line in lines)
    between_kernels = next(r for r in rows(tmp_path / "operators.csv") if r["methods"] == "mdr - bem")
    assert float(between_kernels["whole space"]) <= 1e-8
