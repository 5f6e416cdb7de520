"""`ringwear.study`: its return value, its refusals, and its files."""

from __future__ import annotations

import pandas as pd
import pytest

import ringwear
from ringwear import SceneError, study


@pytest.fixture(scope="module")
def march():
    return study("march", "five_rings", quick=True)


def test_a_study_has_a_row_for_each_level_and_an_order_for_each_sequence(march):
    levels = march.table.groupby("family").size()
    assert levels["explicit march"] == levels["implicit march"] == 4
    # Euler's methods are of the first order
    eulers = march.orders[march.orders["expected order"] == 1]
    assert len(eulers) == 2
    assert (eulers["lower end"] < eulers["upper end"]).all()
    assert set(march.figures) == {"march"}
    assert march.conclusions[0].startswith("2 of 2 orders")


def test_a_study_displays_itself_in_a_notebook(march):
    shown = march._repr_html_()
    assert "data:image/png;base64," in shown
    assert "implicit march" in shown
    assert repr(march).startswith("Study march of ")


def test_a_saved_study_has_its_tables_in_three_formats(march, tmp_path):
    names = set(march.save(tmp_path))
    assert {"march.csv", "march.md", "march.tex", "orders.tex", "march.png"} <= names
    read = pd.read_csv(tmp_path / "march.csv")
    assert len(read) == len(march.table)
    assert march.to_latex("orders") == (tmp_path / "orders.tex").read_text("utf-8")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: study("convergance"), "give one of paper, convergence"),
        (lambda: study("march", "sphere"), "flat punches under a force"),
        (lambda: study("elements", "rotating_pin"), "one wear coefficient"),
        (lambda: study("march", meshes=["a.msh"]), "does not accept meshes"),
    ],
)
def test_a_study_refuses_unknown_options(call, message):
    with pytest.raises(SceneError, match=message):
        call()


def test_marches_are_of_first_order_if_wear_varies_along_the_radius():
    results = study("march", "rotating_pin", quick=True)
    assert results.orders["expected order"].tolist() == [1.0, 1.0]
    assert results.orders["least squares"].tolist() == pytest.approx([1.0, 1.0], abs=0.05)
    assert "a full disc" in results.conclusions[-1]


def test_an_unknown_table_is_refused(march):
    with pytest.raises(SceneError, match="give one of"):
        march.to_markdown("order")


def test_a_study_is_a_public_name():
    assert "study" in dir(ringwear)
