"""The quick studies: conclusions of their tables, and the files that they write."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, SceneError, main, study


def conduct(name, out):
    """Return the results of a quick study, whose files are written."""
    results = study(name, "five_rings", quick=True)
    assert results.conclusions
    assert f"{name}.csv" in results.save(out)
    return results


FEM = {2: 4, 3: 6, 4: 8}
ONE_RING = {
    **{f"P{degree}, graded": order for degree, order in FEM.items()},
    **{f"P{degree}, uniform": 1 for degree in FEM},
    **{f"MDR degree {degree}, graded": 2 * degree + 3 for degree in (1, 2)},
    "quadrilaterals in layers": pytest.approx(np.log10(9)),
}


@pytest.mark.slow
@pytest.mark.gmsh
def test_orders_of_one_ring_are_those_of_theory(tmp_path):
    fits = conduct("convergence", tmp_path).orders
    judged = fits[(fits["case"] == "one ring") & fits["expected"].notna()]
    starts = judged[judged["quantity"] == "indentation"]
    assert set(starts["agrees"]) == {"yes"}
    assert dict(zip(starts["way"], starts["expected"], strict=True)) == ONE_RING
    # of the scene, orders of MDR and of elements of degree one agree as well
    scene = fits[(fits["case"] == "scene") & (fits["agrees"] == "yes")]
    assert {"P1, graded", "Q1, graded", "MDR degree 1, graded"} <= set(scene["way"])
    written = pd.read_csv(tmp_path / "convergence.csv")
    assert {"mdr", "bem", "fem"} == set(written["method"])


@pytest.mark.gmsh
def test_orders_of_far_fields_are_those_of_theory(tmp_path):
    fits = conduct("truncation", tmp_path).orders
    assert set(fits["agrees"]) == {"yes"}
    assert fits["expected"].tolist() == [1, 5, 9, 13]


def test_the_stability_limit_of_the_papers_grid_is_listed(tmp_path):
    results = conduct("march", tmp_path)
    assert (results.tables["paper_grid"]["relative difference from 4/(pi n k)"].abs() <= 0.15).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "load", "quantity"),
    [
        ("cone", {"normal_force": 1.0}, "indentation"),
        ("sphere", {"indentation": 0.1}, "normal_force"),
    ],
)
def test_errors_of_shaped_punches_fall_with_finer_cells(scene, load, quantity, tmp_path):
    shaped = Scene.load(scene).changed(load=load, wear__times=[0.0, 0.03, 0.3])
    (tmp_path / "scene.toml").write_text(shaped.to_toml(), "utf-8")
    out = tmp_path / "out"
    arguments = [str(tmp_path / "scene.toml"), "--quick", "--out", str(out)]
    assert main(["study", "convergence", *arguments]) == 0
    rows = pd.read_csv(out / "convergence.csv")
    elements = [f"{name} below cells" for name in ("P1", "P2", "P3", "P4", "Q1", "Q2")]
    assert rows["way"].unique().tolist() == ["MDR", "BEM", *elements]
    later = rows[rows["when"] == "later"]
    for way, levels in later.groupby("way"):
        assert levels["unknowns"].is_monotonic_increasing
        errors, profiles = (
            levels[levels["quantity"] == name]["error"].abs().to_numpy()
            for name in (quantity, "profile")
        )
        # errors of elements of degree 1 and 2 below the surface exceed the gain of smaller cells
        least = 1.0 if way[:2] in ("P1", "P2", "Q1", "Q2") else 1.5
        assert errors[0] > least * errors[-1] > 0, way
        assert profiles[0] > profiles[-1], way
        assert errors[-1] < (0.03 if way[1] == "1" else 1e-3), way
    assert main(["study", "refinement", *arguments]) == 2


@pytest.mark.slow
@pytest.mark.gmsh
def test_tradeoff_measures_every_method_and_group(tmp_path):
    with pytest.raises(SceneError) as refusal:
        study("tradeoff", methods=["absent"])
    ways = str(refusal.value).partition("give some of ")[2].partition(", or methods")[0].split(", ")
    table = conduct("tradeoff", tmp_path).table
    measured = table[table["outcome"] == "solved"]
    assert set(measured["method"]) == {each.split()[0] for each in ways}
    assert measured["case"].nunique() == 4
    promised = measured.dropna(subset=["tolerance"])
    assert set(promised["method"]) == {"mdr", "bem", "fem"}
    assert (promised["error"].abs() <= promised["tolerance"]).all()
    assert (promised["least seconds"] <= promised["seconds"]).all()
    assert (promised["seconds"] <= promised["greatest seconds"]).all()


@pytest.mark.slow
@pytest.mark.gmsh
def test_a_scene_varies_the_keys_that_it_has(tmp_path):
    """Every run of our methods keeps its tolerance or states that it does not."""
    table = conduct("extremes", tmp_path).table
    keys = ["half_space.poisson_ratio", "punch.wear_ratio", "punch.width_ratio", "wear.times"]
    assert list(table["key"].unique()) == [*keys, "accuracy.rtol"]
    ours = table[table["method"] != "naive"]
    assert not {"wrong", "crashed"} & set(ours["verdict"])
    assert "wrong" in set(table[table["method"] == "naive"]["verdict"])
