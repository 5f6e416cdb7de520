"""Orders by sequences of levels, against exact sequences, and the two studies that state orders, in
their quick version.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ringwear import Scene
from ringwear.meshes import bisection
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import SolverError
from ringwear.meshes.half_space import contact_radii, quality
from ringwear.meshes.sizes import SizeField
from ringwear.studies import truncation
from ringwear.studies.convergence import study as convergence
from ringwear.studies.convergence.cases import FLAT, by_mdr, flat_d0
from ringwear.studies.convergence.meshes import subdivided
from ringwear.studies.convergence.orders import VERDICT, Refinement, Sequence, refined, verdicts
from ringwear.studies.registry import INTERRUPTED

SIZES = np.array([0.5, 0.3, 0.2, 0.1])


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 7.5])
@pytest.mark.parametrize("sign", [1, -1])
def test_orders_of_an_exact_sequence(order: float, sign: int) -> None:
    errors = sign * 0.3 * SIZES**order
    levels = Sequence("h", "value", order, exact=2.0, sizes=SIZES, values=2 + errors)
    assert levels.orders == pytest.approx(order)
    assert (levels.order, levels.last_order) == pytest.approx((order, order))


def test_levels_below_the_floor_are_left_out_of_orders() -> None:
    levels = Sequence("h", "value", 2.0, exact=1.0, floor=0.05)
    for size in SIZES:
        levels.add(size, 1 + max(size**2, 0.045))
    assert levels.order == pytest.approx(2)
    assert levels.summary()["levels"] == "2 of 4"
    assert levels.summary()["between levels"] == "2.00 (1.71) (-0.00)"


def test_levels_before_the_asymptotic_range_are_left_out_of_orders() -> None:
    levels = Sequence("h", "value", 2.0, exact=0.0, coarsest=0.3)
    for size in SIZES:
        levels.add(size, size**2 if size <= 0.3 else 1.0)
    assert levels.errors[-1] == pytest.approx(
        0.01
    )  # of what should be zero, the error is the value
    assert (levels.order, levels.last_order) == pytest.approx((2, 2))
    assert levels.summary()["levels"] == "3 of 4"


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
    levels = Sequence("h", "value", 2.0, exact=1.0, sizes=SIZES, values=1 + errors)
    no_theory = Sequence("h", "value", exact=1.0, sizes=SIZES, values=1 + errors)
    assert levels.verdict == verdict
    assert no_theory.verdict == ""
    assert verdicts([levels, no_theory]).startswith("1 of 1" if verdict == "yes" else "0 of 1")


def test_levels_that_fail_are_rows_and_those_before_ctrl_c_are_kept(tmp_path: Path) -> None:
    def discretise(grading: float) -> tuple[Compliance, int]:
        if grading == 0.5:
            raise SolverError("singular")
        if grading == 0.7:
            raise KeyboardInterrupt
        return by_mdr(FLAT, 1e-3, 1, grading)

    levels = {grading: 1 - grading for grading in (0.5, 0.6, 0.7, 0.8)}
    conclusions: list[str] = []
    (sequence,) = refined(
        [Refinement([Sequence("h", "d0", exact=0.5)], levels, discretise, flat_d0)],
        tmp_path / "levels.csv",
        conclusions,
    )
    assert conclusions == [INTERRUPTED]
    assert sequence.sizes == pytest.approx([0.4])
    failed, computed = rows(tmp_path / "levels.csv")
    assert failed["remark"] == "failed: singular"
    assert float(computed["error"]) == pytest.approx(sequence.errors[0])


@pytest.mark.parametrize("count", [1, 2, 3])
def test_subdivision(count: int) -> None:
    base = bisection.mesh(SizeField((0.0, 0.4, 1.0), 1e-5, 1e-4, 0.8, 20.0))
    fine = subdivided(base, count, np.array([0.4, 1.0]))
    assert fine.nelements == count**2 * base.nelements
    # points put on the arc cost the triangles beside it some of their shape
    assert quality(fine).min() > 0.5 * quality(base).min()
    # every vertex of the base is kept, and the arc is an arc
    assert np.isin(contact_radii(base), contact_radii(fine)).all()
    far = fine.p[:, np.unique(fine.facets[:, fine.boundaries["far"]])]
    assert np.hypot(*far) == pytest.approx(20.0, rel=1e-12)


def conducted(study: Any, out: Path) -> tuple[list[str], list[dict[str, str]]]:
    """Conclusions, and the table of orders that have a theory."""
    lines = study.conduct(Scene.load("five_rings"), out, argparse.Namespace(quick=True))
    assert {path.suffix for path in out.iterdir()} == {".csv", ".md", ".png"}
    return lines, [row for row in rows(out / "orders.csv") if row["expected order"] != "nan"]


@pytest.mark.gmsh
def test_convergence(tmp_path: Path) -> None:
    lines, orders = conducted(convergence, tmp_path)
    assert {row[VERDICT] for row in orders} == {"yes"}
    expected = {(row["refined"], row["quantity"]): float(row["expected order"]) for row in orders}
    for degree, theory in ((2, 4), (3, 6), (4, 8)):
        assert expected[f"FEM P{degree}, graded", "d0"] == theory
        assert expected[f"FEM P{degree}, uniform", "d0"] == 1
    for degree in (1, 2):
        assert expected[f"MDR degree {degree}, graded", "d0"] == 2 * degree + 3
    assert f"{len(orders)} of {len(orders)} orders are within 0.15 of theory" in lines[1]


def test_truncation(tmp_path: Path) -> None:
    lines, orders = conducted(truncation, tmp_path)
    assert {row[VERDICT] for row in orders} == {"yes"}
    assert {(row["refined"], row["quantity"]): float(row["expected order"]) for row in orders} == {
        ("nu = 0.3", far_field): order
        for far_field, order in {"fixed": 1, "1 pole": 5, "2 poles": 9, "3 poles": 13}.items()
    }
    assert "1 pole 4.9" in lines[0]
