"""Orders of convergence of exact sequences, levels that fail, and subdivided meshes."""

from __future__ import annotations

import numpy as np
import pytest

from ringwear import Scene, SizeField, SolverError, bisection
from ringwear.meshes.half_space import contact_radii, quality
from ringwear.studies.numerics.subdivision import subdivided
from ringwear.studies.study.levels import Family, Record, Theory
from ringwear.studies.study.orders import Sequence
from ringwear.studies.study.study_orders import study_orders
from ringwear.studies.tables import INTERRUPTED

SIZES = np.array([0.5, 0.3, 0.2, 0.1])


def sequence(errors, order=2.0):
    return Sequence("h", "value", Theory(order), SIZES, errors)


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 7.5])
@pytest.mark.parametrize("sign", [1, -1])
def test_orders_of_an_exact_sequence(order, sign):
    fitted = sequence(sign * 0.3 * SIZES**order)
    assert fitted.orders == pytest.approx(order)
    assert (fitted.order, fitted.last_order) == pytest.approx((order, order))


def test_levels_below_the_floor_are_left_out_of_orders():
    fitted = Sequence("h", "value", Theory(2.0, floor=0.05), SIZES, np.maximum(SIZES**2, 0.045))
    assert (fitted.order, fitted.last_order) == pytest.approx((2, 2))
    assert fitted.summary()["levels"] == "2 of 4"
    assert fitted.orders == pytest.approx([2.0, 1.71, 0.0], abs=0.01)


@pytest.mark.parametrize(
    ("errors", "verdict"),
    [
        (SIZES**2, "yes"),
        (SIZES**2.2, "no"),
        (SIZES**2 * (1 - SIZES), "no"),
        (np.array([1.0, 0.0, 0.0, 0.0]), "too few levels above the floor"),
        # the fitted order is right by chance, but that of the last levels is not
        (np.array([0.5**2, 0.3**2, 0.2**2, 0.9 * 0.1**2]), "no"),
    ],
)
def test_verdicts_on_orders(errors, verdict):
    assert sequence(errors).verdict == verdict
    assert sequence(errors, order=np.nan).verdict == ""


class Fields:
    """Levels ``exact + c h^order`` of a field of two numbers, in the maximum norm."""

    def __init__(self, order):
        self.wrong = np.outer(SIZES**order, [0.3, -0.2])

    @property
    def changes(self):
        return np.abs(np.diff(self.wrong, axis=0)).max(axis=1)

    def error_of_limit(self, weight):
        return np.abs(self.wrong[-1] + weight * (self.wrong[-1] - self.wrong[-2])).max()


@pytest.mark.parametrize("order", [0.5, 2.0])
def test_richardsons_limit_of_fields_is_exact(order):
    fields = Fields(order)
    errors = np.abs(fields.wrong).max(axis=1)
    limit, index = Sequence("h", "p", Theory(order), SIZES, errors, fields).richardson
    assert limit == pytest.approx(0, abs=1e-12)
    # the distance of the finest level from the limit, times Roache's factor
    assert index == pytest.approx(1.25 * errors[-1])


def test_levels_that_fail_are_rows_and_those_before_ctrl_c_are_kept(tmp_path):
    def solve(size):
        if size == 0.3:
            raise SolverError("singular")
        if size == 0.1:
            raise KeyboardInterrupt
        return {"value": size**2}

    family = Family("h", {size: size for size in SIZES}, solve, {"value": Theory(2.0)})
    scene, record = Scene.load("flat_punch"), Record(tmp_path)
    conclusions = study_orders([family], record, "levels", scene, "error").conclusions
    assert conclusions[0].startswith("1 of 1")
    assert conclusions[1] == "h, value: 2.00 (theory 2: yes), finest error 4.0e-02"
    assert conclusions[-1] == INTERRUPTED
    _, *written = (tmp_path / "levels.csv").read_text("utf-8").splitlines()
    assert len(written) == 3
    assert "failed: singular" in written[1]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_subdivision(count):
    base = bisection.mesh(SizeField((0.0, 1.0), 1e-5, 1e-4, 0.8, 20.0))
    fine = subdivided(base, count)
    assert fine.nelements == count**2 * base.nelements
    # triangles at the arc lose some quality, because their points are moved onto it
    assert quality(fine).min() > 0.5 * quality(base).min()
    # every vertex of the base is kept, and the points of the arc have its radius
    assert np.isin(contact_radii(base), contact_radii(fine)).all()
    far = fine.p[:, np.unique(fine.facets[:, fine.boundaries["far"]])]
    assert np.hypot(*far) == pytest.approx(20.0, rel=1e-12)
