"""The quick studies: conclusions of their tables, and the files that they write."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from ringwear import Scene, SceneError, main, study

Rows = list[dict[str, str]]


def conduct(name, out):
    """Return the rows of each table of a quick study."""
    results = study(name, "five_rings", quick=True)
    assert results.conclusions
    assert f"{name}.png" in results.save(out)
    return {
        file.stem: list(csv.DictReader(file.read_text("utf-8").splitlines()))
        for file in out.glob("*.csv")
    }


FEM = {2: 4, 3: 6, 4: 8}
ORDERS = {
    "convergence": {
        **{(f"FEM P{degree}, graded", "d0"): order for degree, order in FEM.items()},
        **{(f"FEM P{degree}, uniform", "d0"): 1 for degree in FEM},
        **{(f"MDR degree {degree}, graded", "d0"): 2 * degree + 3 for degree in (1, 2)},
        ("MDR degree 1, rings", "d(1)"): 4,
        ("MDR degree 1, rings", "slowest relaxation time"): 4,
        ("MDR degree 1, rings", "RMS gradient"): 2,
        ("FEM quads, digits per degree", "d0"): pytest.approx(np.log10(9)),
    },
    "truncation": {
        ("nu = 0.3", far): order
        for far, order in {"fixed": 1, "1 pole": 5, "2 poles": 9, "3 poles": 13}.items()
    },
    "march": {(f"{march} march", "indentation error"): 1 for march in ("explicit", "implicit")},
}


@pytest.mark.gmsh
@pytest.mark.parametrize(
    "name", [pytest.param("convergence", marks=pytest.mark.slow), "truncation", "march"]
)
def test_orders_are_those_of_theory(name, tmp_path):
    tables = conduct(name, tmp_path)
    judged = {
        (row["refined"], row["quantity"]): row
        for row in tables["orders"]
        if row["expected order"] and not row["refined"].endswith("scene")
    }
    assert {row["within 0.15"] for row in judged.values()} == {"yes"}
    assert {key: float(row["expected order"]) for key, row in judged.items()} == ORDERS[name]
    # the stability limit of explicit steps, over 4/(pi n k) of n springs, less 1
    limits = [
        float(value or 0)
        for row in tables.get("march", ())
        for column, value in row.items()
        if column.startswith("limit over")
    ]
    assert bool(limits) == (name == "march")
    assert all(abs(limit) <= 0.15 for limit in limits)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "load", "quantity"),
    [
        ("cone", {"normal_force": 1.0}, "d(t)"),
        ("sphere", {"indentation": 0.1}, "normal force"),
    ],
)
def test_errors_of_shaped_punches_fall_with_finer_cells(scene, load, quantity, tmp_path):
    shaped = Scene.load(scene).changed(load=load, wear__times=[0.0, 0.03, 0.3])
    (tmp_path / "scene.toml").write_text(shaped.to_toml(), "utf-8")
    out = tmp_path / "out"
    arguments = [str(tmp_path / "scene.toml"), "--quick", "--out", str(out)]
    assert main(["study", "convergence", *arguments]) == 0
    rows = list(csv.DictReader((out / "convergence.csv").read_text("utf-8").splitlines()))
    families = list(dict.fromkeys(row["family"] for row in rows))
    elements = ["FEM P1", "FEM P2", "FEM P3", "FEM P4", "FEM Q1", "FEM Q2"]
    assert families == ["MDR", "BEM", *elements]
    for family in families:
        levels = [row for row in rows if row["family"] == family]
        unknowns = [int(row["unknowns"]) for row in levels]
        assert unknowns == sorted(unknowns)
        coarse, fine = levels[0], levels[-1]
        # errors of elements of degree 1 and 2 below the surface exceed the gain of smaller cells
        low = family.endswith(("P1", "P2", "Q1", "Q2"))
        least = 1.0 if low else 1.5
        assert float(coarse[quantity]) > least * float(fine[quantity]) > 0
        assert float(coarse["profile"]) > float(fine["profile"])
        assert float(fine[quantity]) < (0.03 if family.endswith("1") else 1e-3)
    assert main(["study", "refinement", *arguments]) == 2


@pytest.mark.slow
@pytest.mark.gmsh
def test_tradeoff_measures_every_method_and_group(tmp_path):
    with pytest.raises(SceneError) as refusal:
        study("tradeoff", methods=["absent"])
    ways = str(refusal.value).partition("give some of ")[2].split(", ")
    tables = conduct("tradeoff", tmp_path)
    measured = [row for row in tables["tradeoff"] if not row["remark"]]
    assert {row["method"] for row in measured} == set(ways)
    assert len({row["group"] for row in measured}) == 4
    for row in measured:
        if row["method"] in ("mdr", "bem", "fem"):
            assert float(row["error"]) <= float(row["setting"].removeprefix("rtol "))
