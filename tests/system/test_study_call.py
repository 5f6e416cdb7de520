"""`ringwear.study`: its return value, its refusals, and its files."""

from __future__ import annotations

import logging

import pandas as pd
import pytest

import ringwear
from ringwear import SceneError, SizeField, bisection, study
from ringwear.studies.refinement import ways
from ringwear.studies.study.levels import Family, Progress, Record


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


def test_progress_prints_the_level_and_the_time_left(caplog):
    family = Family("h", {1: 1.0, 2: 0.5, 3: 0.25}, lambda _: {"value": 1.0})
    with caplog.at_level(logging.INFO, logger="ringwear"):
        Record().solve("t", [family], ["family", "setting", "size", "value"])
    lines = [record.getMessage() for record in caplog.records]
    assert lines[0].startswith("   level 1 of 3: h, 1")
    assert lines[2].startswith("   level 3 of 3, about ")


def test_time_left_follows_from_the_seconds_of_earlier_levels():
    progress = Progress([1.0, 3.0, 6.0])
    progress.finish(2.0)
    assert progress.seconds_left == pytest.approx(18.0)
    progress.finish(6.0)
    assert progress.seconds_left == pytest.approx(12.0)


def test_a_study_is_a_public_name():
    assert "study" in dir(ringwear)


def test_the_study_of_refinement_has_a_line_for_the_users_mesh(tmp_path, monkeypatch):
    # leave out levels that take long
    monkeypatch.setattr(ways, "ACCURACIES_QUICK", (1e-1,))
    monkeypatch.setattr(ways, "MOST_UNKNOWNS_QUICK", 1000)
    file = tmp_path / "mine.vtu"
    field = SizeField((0.0, 0.5, 1.0), 0.02, 0.05, 0.8, 4.0)
    bisection.mesh(field).save(file, file_format="vtu")
    results = study("refinement", "flat_punch", quick=True, meshes=[str(file)], degree=3)
    assert results.conclusions[0].startswith("flat punch: mine.vtu, ")
    assert "of degree 3" in results.conclusions[0]
    written = set(results.save(tmp_path / "out"))
    assert {"refinement.csv", "refinement.md", "error_against_unknowns.png"} <= written


def test_the_study_of_refinement_refuses_a_mesh_file_that_is_absent(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        study("refinement", "five_rings", quick=True, meshes=[str(tmp_path / "absent")])
