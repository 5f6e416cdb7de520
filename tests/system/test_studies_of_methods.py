"""The quick studies: conclusions of their tables, and the files that they write."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, SceneError, study
from ringwear.studies.extremes import keys_of_scene


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
    judged = fits[(fits["case"] == "one ring") & fits["theory"].notna()]
    starts = judged[judged["quantity"] == "indentation"]
    assert not starts["remark"].str.startswith("differs").any()
    assert dict(zip(starts["way"], starts["theory"], strict=True)) == ONE_RING
    # of the scene, orders of MDR and of elements of degree one agree as well
    scene = fits[(fits["case"] == "scene") & fits["theory"].notna()]
    scene = scene[~scene["remark"].str.startswith("differs")]
    assert {"P1, graded", "Q1, graded", "MDR degree 1, graded"} <= set(scene["way"])
    written = pd.read_csv(tmp_path / "convergence.csv")
    assert {"mdr", "bem", "fem"} == set(written["method"])


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


@pytest.mark.nightly
@pytest.mark.gmsh
def test_a_scene_varies_the_keys_that_it_has(tmp_path):
    """Every run of our methods keeps its tolerance or states that it does not."""
    table = conduct("extremes", tmp_path).table
    keys = ["half_space.poisson_ratio", "punch.wear_ratio", "punch.width_ratio", "wear.times"]
    assert list(table["key"].unique()) == [*keys, "accuracy.rtol"]
    ours = table[table["method"] != "naive"]
    assert not {"wrong", "crashed"} & set(ours["verdict"])
    assert "wrong" in set(table[table["method"] == "naive"]["verdict"])


@pytest.mark.slow
def test_a_user_quantity_replaces_the_groups():
    # Boussinesq: F / (2 a E*) for a flat punch
    def first_depth(result):
        return float(result.dataset.indentation[0, 0])

    scene = Scene.load("flat_punch").changed(wear__times=[0.0, 0.1])
    results = study("tradeoff", scene, quick=True, quantities=[first_depth], methods=["mdr"])
    assert results.table["quantity"].unique().tolist() == ["first_depth"]
    assert (results.table["error"].abs() <= results.table["tolerance"]).all()
    assert results.table["estimate"].isna().all()
    assert set(results.tables) == {"costs"}


@pytest.mark.slow
def test_direct_integration_is_timed_for_the_steady_state():
    scene = Scene.load("five_rings").changed(wear__times=[])
    results = study("tradeoff", scene, quick=True, methods=["mdr", "direct"])
    table = results.table[results.table["case"] == "steady state"]
    by_mdr = table[table["method"] == "mdr"]
    assert by_mdr["tolerance"].unique().tolist() == [1e-1, 1e-2, 1e-3]
    # true errors are within the tolerance and within the estimate
    assert (by_mdr["error"].abs() <= by_mdr["tolerance"]).all()
    assert (by_mdr["estimate"] >= by_mdr["error"].abs()).all()
    assert table[table["method"] == "direct"]["tolerance"].isna().all()


def test_a_method_that_fails_is_a_row_with_the_reason(command):
    """The others go on; the answer fits a terminal, and the sentences are few and short."""
    Path("mine.py").write_text(
        "from ringwear import method\n"
        "class Failing(type(method('mdr'))):\n"
        "    name = 'failing'\n"
        "    def discretise(self, problem, stages):\n"
        "        raise ValueError('it fails for a reason with more words than fit a table')\n"
    )
    options = "--vary half_space.poisson_ratio=0.1:0.3:2 --methods mdr,mine.py:Failing"
    printed = command(f"study extremes flat_punch --quick {options} --out out").out
    lines = printed.splitlines()
    table = [line for line in lines if line.startswith("|")]
    assert len(table) <= 40
    assert max(map(len, table)) <= 100
    sentences = lines[lines.index(table[-1]) + 1 : -2]
    assert 0 < len(sentences) <= 8
    assert max(len(line.split()) for line in sentences) <= 30
    answer = pd.read_csv("out/answer.csv").set_index("way")
    assert "it fails for a reason" in answer["not solved: because"]["failing"]
    assert answer["within tolerance"]["MDR"] == "2 of 2"


def test_keys_of_layers_are_varied_and_values_that_are_refused_are_rows():
    varied = keys_of_scene(Scene.load("hard_film"), quick=True)
    (least, greatest) = varied["half_space.layers.0.thickness"]
    assert greatest == pytest.approx(900 * least, rel=1e-5)
    table = study(
        "extremes",
        "flat_punch",
        quick=True,
        key="half_space.poisson_ratio",
        values=[0.3, 0.7],
        methods=["mdr"],
    ).table
    (row,) = table[table["case"] == "half_space.poisson_ratio = 0.7"].to_dict("records")
    assert row["outcome"] == "refused"
    assert "poisson_ratio = 0.7" in row["message"]


def test_any_two_columns_are_drawn():
    results = study("truncation", quick=True, radii=[4, 5, 6])
    axes, *_ = results.plot(x="unknowns", y="seconds").axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("unknowns", "seconds")
    assert len(axes.get_lines()) == 4
    assert results.orders["theory"].tolist() == [1, 5, 9, 13]
    assert not results.orders["remark"].str.startswith("differs").any()
    with pytest.raises(SceneError, match="no level has 'way' and 'error': give two of"):
        results.plot(x="way")
