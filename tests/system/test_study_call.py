"""`ringwear.study`: its return value, its refusals, and its files."""

import pandas as pd
import pytest

from ringwear import Scene, SceneError, study


@pytest.fixture(scope="module")
def march():
    return study("march", "five_rings", quick=True)


def test_a_study_has_a_row_for_each_level_and_an_order_for_each_sequence(march):
    columns = [
        "case",
        "way",
        "method",
        "level",
        "size",
        "unknowns",
        "seconds",
        "quantity",
        "when",
        "error",
        "estimate",
    ]
    assert list(march.table)[: len(columns)] == columns
    levels = march.table.groupby("way")["level"].nunique()
    assert levels.to_dict() == {"explicit Euler": 4, "implicit Euler": 11}
    # Euler's methods are of the first order
    eulers = march.orders[march.orders["theory"] == 1]
    assert len(eulers) == 4
    assert (eulers["low"] < eulers["high"]).all()
    assert set(march.figures) == {"march"}


def test_a_march_says_which_step_is_needed(march):
    assert any("steps are stable below 0.002" in line for line in march.conclusions)
    # the longest step within 1 % errs by less, and the next longer one by more
    costs = march.tables["costs"].set_index(["way", "quantity", "goal"])
    step = costs["step"]["implicit Euler", "pressure", 1e-2]
    rows = march.table[march.table["quantity"] == "pressure"].sort_values("step")
    implicit = rows[rows["way"] == "implicit Euler"]
    assert (implicit[implicit["step"] <= step]["error"] <= 1e-2).all()
    assert implicit[implicit["step"] > step]["error"].iloc[0] > 1e-2


def test_steps_of_the_user_are_taken_as_given():
    scene = Scene.load("five_rings").changed(wear__times=[0.0, 1.0])
    results = study("march", scene, quick=True, steps=[0.3, 0.1, 0.004, 0.001])
    steps = results.table.groupby("way")["step"].unique()
    assert steps["implicit Euler"].tolist() == pytest.approx([0.3, 0.1, 0.004, 0.001])
    # those above the stability limit are left out of the explicit march, and named
    assert steps["explicit Euler"].tolist() == pytest.approx([0.001])
    assert any("leaves out the steps 0.3, 0.1, 0.004" in line for line in results.conclusions)


def test_a_study_displays_itself_in_a_notebook(march):
    shown = march._repr_html_()
    assert "data:image/png;base64," in shown
    assert "implicit Euler" in shown
    assert repr(march).startswith("Study march of ")


def test_a_saved_study_has_its_tables_in_three_formats(march, tmp_path):
    names = set(march.save(tmp_path))
    assert {"march.csv", "answer.md", "answer.tex", "orders.tex", "march.png"} <= names
    read = pd.read_csv(tmp_path / "march.csv")
    assert len(read) == len(march.table)
    assert march.to_latex("orders") == (tmp_path / "orders.tex").read_text("utf-8")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: study("march", "sphere"), "flat punches under a force"),
        (lambda: study("march", meshes=["a.msh"]), "does not accept meshes"),
    ],
)
def test_a_study_refuses_unknown_options(call, message):
    with pytest.raises(SceneError, match=message):
        call()


def test_marches_are_of_first_order_if_wear_varies_along_the_radius():
    results = study("march", "rotating_pin", quick=True)
    implicit = results.orders[results.orders["way"] == "implicit Euler"]
    assert set(implicit["quantity"]) == {"indentation", "pressure", "profile"}
    assert implicit["theory"].tolist() == [1.0] * 3
    assert implicit["order"].tolist() == pytest.approx([1.0] * 3, abs=0.05)


def test_an_unknown_table_is_refused(march):
    with pytest.raises(SceneError, match="give one of"):
        march.to_markdown("order")


@pytest.mark.gmsh
def test_far_fields_of_a_hollow_punch_are_those_of_a_disc():
    """The study of truncation presses a disc, whatever the punch of the scene is."""
    results = study("truncation", "washer", radii=[4, 5], quick=True)
    finest = results.orders.groupby("way")["finest error"].max()
    assert finest["clamped"] > 1e-2
    assert finest["3 poles"] < 1e-8
