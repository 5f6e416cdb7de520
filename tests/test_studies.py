"""The studies: the machinery of orders against exact sequences, and the quick version of each study."""

from __future__ import annotations

import argparse
import csv
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ringwear.meshes.errors import SolverError
from ringwear.meshes.half_space import contact_radii, quality
from ringwear.meshes.size_field import SizeField
from ringwear.studies import compare, truncation
from ringwear.studies import time_steps as march
from ringwear.studies.cli import main
from ringwear.studies.convergence import study as convergence
from ringwear.studies.convergence.levels import (
    VERDICT,
    Sequence,
    Table,
    between,
    extrapolated,
    keeping_rows,
    least_squares,
    verdicts,
)
from ringwear.studies.convergence.levels import order_of_three as of_three
from ringwear.studies.convergence.study import LEVEL_FIELDS, Recorder
from ringwear.studies.extremes import study as extremes
from ringwear.studies.progress import silent
from ringwear.studies.refinement import study as refinement
from ringwear.studies.refinement.subdivision import subdivided
from ringwear.studies.registry import INTERRUPTED

from ringwear import Scene

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
    assert sequence.summary()["between levels"] == "2.00 (1.71) (-0.00)"


def test_levels_before_the_asymptotic_range_are_left_out_of_orders() -> None:
    sequence = Sequence("h", "value", 2.0, exact=0.0, coarsest=0.3)
    for size in SIZES:
        sequence.add(size, size**2 if size <= 0.3 else 1.0)
    assert sequence.errors[-1] == pytest.approx(0.01)  # of what should be zero, the error is the value
    assert (sequence.order, sequence.last_order) == pytest.approx((2, 2))
    assert sequence.summary()["levels"] == "3 of 4"


@pytest.mark.parametrize(
    ("errors", "verdict"),
    [
        (SIZES**2, "yes"),
        (SIZES**2.2, "no"),
        (SIZES**2 * (1 - SIZES), "no: still approaching"),
        (SIZES**2 - 0.05, "no: the error changes sign"),
        (np.array([1.0, 0.0, 0.0, 0.0]), "too few levels above the floor"),
        # fitted well by chance, while the last levels are off
        (np.array([0.5**2, 0.3**2, 0.2**2, 0.9 * 0.1**2]), "no"),
    ],
)
def test_verdicts_on_orders(errors: np.ndarray, verdict: str) -> None:
    sequence = Sequence("h", "value", 2.0, exact=1.0)
    for size, error in zip(SIZES, errors, strict=True):
        sequence.add(size, 1 + error)
    assert sequence.verdict == verdict
    assert verdicts([sequence]).startswith("1 of 1" if verdict == "yes" else "0 of 1")
    assert Sequence("h", "no theory", exact=1.0, sizes=SIZES, values=1 + errors).verdict == ""


def test_rows_are_on_disk_at_once_and_kept_on_interruption(tmp_path: Path) -> None:
    table, conclusions = Table(tmp_path / "t.csv", ("a", "b")), []
    with keeping_rows(conclusions):
        table.add(a=1, b="x")
        assert rows(tmp_path / "t.csv") == [{"a": "1", "b": "x"}]
        raise KeyboardInterrupt
    assert conclusions == [INTERRUPTED]


@pytest.mark.parametrize("calls", [1, 2])
@pytest.mark.parametrize("study", [convergence, truncation, refinement, extremes, march], ids=lambda study: study.__name__)
def test_a_study_stopped_early_keeps_its_tables(study: Any, calls: int, tmp_path: Path) -> None:
    left = iter(range(calls - 1))

    def stop(_: str) -> None:
        if next(left, None) is None and not stopped:
            stopped.append(True)
            raise KeyboardInterrupt

    stopped: list[bool] = []
    lines = study.conduct(Scene.load("five_rings"), tmp_path, argparse.Namespace(quick=True, mesh=None), stop)
    assert INTERRUPTED in lines
    assert len(list(tmp_path.glob("*.csv"))) >= 1
    assert INTERRUPTED in next(tmp_path.glob("*.md")).read_text("utf-8")


WAITING = """
import signal, sys, time
from ringwear.studies import registry as study
from ringwear.studies.cli import main
from ringwear.studies.convergence.levels import Table, keeping_rows

# where the tests themselves run in the background, the shell has told them to ignore it
signal.signal(signal.SIGINT, signal.default_int_handler)

def conduct(scene, out, options, report):
    table, conclusions = Table(out / "rows.csv", ("a",)), []
    with keeping_rows(conclusions):
        table.add(a=1)
        print("waiting", flush=True)
        time.sleep(60)
    return conclusions

study.Study.conduct = property(lambda _: conduct)
sys.exit(main(["study", "march", "--out", sys.argv[1]]))
"""


def test_ctrl_c_in_a_study_keeps_rows_and_says_so_by_its_exit_status(tmp_path: Path) -> None:
    arguments = [sys.executable, "-c", WAITING, str(tmp_path)]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1]) as process:
        assert process.stdout
        assert process.stdout.readline() == "waiting\n"
        process.send_signal(signal.SIGINT)
        printed, _ = process.communicate(timeout=30)
    assert process.returncode == 1
    assert INTERRUPTED in printed
    assert rows(tmp_path / "rows.csv") == [{"a": "1"}]


def test_ctrl_c_outside_of_a_studys_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(march, "mdr_space", stop)
    assert main(["study", "march", "--quick", "--out", str(tmp_path)]) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_level_that_fails_is_a_row(tmp_path: Path) -> None:
    recorder = Recorder(Table(tmp_path / "t.csv", LEVEL_FIELDS), {}, silent)

    def fails() -> tuple[dict[str, float], int]:
        raise SolverError("singular")

    recorder.level("h", 0.1, {}, fails, {})
    assert rows(tmp_path / "t.csv")[0]["remark"] == "failed: singular"


@pytest.mark.parametrize("count", [1, 2, 3])
def test_subdivision(count: int) -> None:
    from ringwear.meshes import bisection

    base = bisection.mesh(SizeField((0.0, 0.4, 1.0), 1e-5, 1e-4, 0.8, 20.0))
    fine = subdivided(base, count, np.array([0.4, 1.0]))
    assert fine.nelements == count**2 * base.nelements
    # points put on the arc cost the triangles beside it some of their shape
    assert quality(fine).min() > 0.5 * quality(base).min()
    # every vertex of the base is kept, and the arc is an arc
    assert np.isin(contact_radii(base), contact_radii(fine)).all()
    far = fine.p[:, np.unique(fine.facets[:, fine.boundaries["far"]])]
    assert np.hypot(*far) == pytest.approx(20.0, rel=1e-12)


@pytest.mark.gmsh
def test_convergence(tmp_path: Path) -> None:
    lines = conducted(convergence, tmp_path)
    orders = rows(tmp_path / "orders.csv")
    assert {row[VERDICT] for row in orders} == {"yes"}
    expected = {(row["refined"], row["quantity"]): float(row["expected order"]) for row in orders}
    for degree, theory in ((2, 4), (3, 6), (4, 8)):
        assert expected[f"FEM P{degree}, graded", "d0"] == theory
        assert expected[f"FEM P{degree}, uniform", "d0"] == 1
    for degree in (1, 2):
        assert expected[f"MDR degree {degree}, graded", "d0"] == 2 * degree + 3
    assert f"{len(orders)} of {len(orders)} orders are within 0.15 of theory" in lines[1]


def test_truncation(tmp_path: Path) -> None:
    lines = conducted(truncation, tmp_path)
    orders = rows(tmp_path / "orders.csv")
    assert {row[VERDICT] for row in orders} == {"yes"}
    assert {(row["shape"], row["far field"]): float(row["expected order"]) for row in orders} == {
        (shape, far_field): order
        for shape in ("disc", "box")
        for far_field, order in {"fixed": 1, "1 pole": 5, "2 poles": 9, "3 poles": 13}.items()
    }
    assert "A box of half-width R against a quarter disc of radius R = 4 a" in lines[2]


def test_march(tmp_path: Path) -> None:
    conducted(march, tmp_path)
    for row in rows(tmp_path / "orders.csv"):
        assert float(row["least squares"]) == pytest.approx(1, abs=0.03)
        assert row[VERDICT] == "yes"
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
