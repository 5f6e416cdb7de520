"""Flat starts by families of meshes have the orders of theory."""

import numpy as np
import pytest

from ringwear import Scene
from ringwear.studies.convergence.flat_start import flat_families
from ringwear.studies.study.levels import Record
from ringwear.studies.study.study_orders import study_orders

# orders of d0, d(1), the slowest relaxation time and the RMS gradient
ORDERS = {
    ("FEM P3, graded", "d0"): 6,
    ("FEM P4, graded", "d0"): 8,
    ("FEM P2, uniform", "d0"): 1,
    ("MDR degree 1, graded", "d0"): 5,
    ("MDR degree 2, graded", "d0"): 7,
    ("MDR degree 1, rings", "d(1)"): 4,
    ("MDR degree 1, rings", "slowest relaxation time"): 4,
    ("MDR degree 1, rings", "RMS gradient"): 2,
    ("FEM quads, digits per degree", "d0"): pytest.approx(np.log10(9)),
}


@pytest.mark.gmsh
def test_flat_starts_have_the_orders_of_theory():
    """Only families without rings are solved, and of similar ones, the fastest."""
    scene, slow = Scene.load("five_rings"), {"FEM P2, graded", "FEM P3, uniform", "FEM P4, uniform"}
    families = [
        family for family in flat_families(scene.problem, quick=True) if family.name not in slow
    ]
    table = study_orders(families, Record(), "convergence", scene, "error").orders
    assert set(table["within 0.15"]) == {"yes"}
    orders = {(row.refined, row.quantity): row["expected order"] for _, row in table.iterrows()}
    assert orders == ORDERS
    assert table.theory.str.endswith(".").all()
