"""Scenes at the limits of what can be computed: estimates hold, and failures are reported."""

import json
from functools import partial

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, Stages, method
from ringwear.studies.extremes import cells as of_map
from ringwear.studies.extremes import naive
from ringwear.studies.extremes.draw import draw_panels
from ringwear.studies.extremes.oracles import judge_by_theory, solve_reference
from ringwear.studies.extremes.panels import NAIVE, naive_errors, read_panels
from ringwear.studies.extremes.study import list_refusals, sort_by_worst

PANELS = {panel.name: panel for panel in read_panels(0.3)}


def cells(quick):
    """Return functions that solve the cells of the map of limits, by family, method, x and y."""
    return {
        (family.name, *cell): partial(family.solve, cell)
        for family in of_map.families(0.3, quick)
        for cell in family.sizes
    }


@pytest.mark.slow
def test_a_quick_cell_of_each_family_and_method_is_judged():
    chosen = {cell[:2]: (cell[0], solve) for cell, solve in cells(quick=True).items()}
    rows = [{"family": family} | solve() for family, solve in chosen.values()]
    assert not {"wrong", "crashed"} & {row["verdict"] for row in rows}
    figure = of_map.draw(pd.DataFrame(rows))
    assert len(figure.axes) == len(chosen)


@pytest.mark.parametrize(
    "place",
    [
        # the width of the ring limits the smallest element, not the size in the settings
        *(("rim_size/a × degree", 0.5, degree) for degree in (8, 16)),
        *(("ring_size/a × degree", 0.5, degree) for degree in (4, 16)),
        ("h2/h1 × k2/k1", 0.01, 1e-8),
        # relaxation times span more than the digits of an eigenvalue
        ("h2/h1 of 3 rings × k2/k1", 2.1e-9, 1e8),
    ],
)
def test_estimates_hold_where_rings_limit_the_mesh(place):
    row = cells(quick=False)[place[0], "mdr", *place[1:]]()
    assert row["error"] <= row["estimate"]
    problem = Scene.from_table(json.loads(row["parameters"])).problem
    if len(problem.times):
        solution = method("mdr").solve(problem, Stages("mdr"))
        error = abs(solution.results["indentation"][0] / 0.5 - 1)
        assert error <= solution.errors["indentation"][0]


@pytest.mark.parametrize("name", PANELS)
def test_the_naive_choice_fails_where_its_panel_says_so(name):
    panel = PANELS[name]
    problem = panel.scene(panel.fails_at, NAIVE).problem
    exact = solve_reference(problem, "mdr", 0.1 * problem.rtol)
    assert max(naive_errors(panel, panel.fails_at, exact).values()) > 0.01


def test_the_naive_choice_is_accurate_in_an_ordinary_scene():
    """The truncation errs by 1.1 a/R = 1.1e-3, and a punch of one material has no ring edges."""
    scene = PANELS["number of rings"].scene(1, NAIVE).changed(wear__times=[0.0, 10.0])
    errors = naive_errors_of(scene.problem, outer=1000.0)
    # the mesh of equal elements has the size 1/20
    assert errors["indentation"][0] < 0.02
    # the steady pressure of one material is uniform (Eq. 24)
    assert naive.solve(scene.problem)["pressure"][1] == pytest.approx(1 / np.pi, rel=5e-3)


def naive_errors_of(problem, outer):
    solution = naive.solve(problem, outer=outer)
    # Eq. 10: the flat start of the force 1
    return {"indentation": np.abs(solution["indentation"] / 0.5 - 1)}


def test_closed_forms_and_balances_detect_wrong_forces_and_indentations():
    scene = PANELS["wear ratio"].scene(10.0, "mdr")
    problem, solution = scene.problem, method("mdr").solve(scene.problem, Stages("mdr"))
    assert {row["verdict"] for row in judge_by_theory(scene, problem, solution)} == {"within"}
    for name in ("ring_force", "indentation"):
        solution.compared[name] *= 1.02
        verdicts = {row["verdict"] for row in judge_by_theory(scene, problem, solution)}
        assert "wrong" in verdicts
        solution.compared[name] /= 1.02


def test_refusals_are_listed_and_the_table_begins_with_the_worst():
    panel = PANELS["step of the march"]
    solve = panel.family(quick=True).solve
    rows = [{"family": panel.name} | solve((1e-2, name)) for name in (*panel.methods, NAIVE)]
    table = pd.DataFrame(rows).assign(y=np.nan)
    ordered = sort_by_worst(table)
    assert ordered.verdict[0] == "refused"
    (text,) = list_refusals(table).message
    assert "unstable" in text
    assert "give a smaller wear.step" in text
    assert ordered.method.iloc[-1] == NAIVE
    figure = draw_panels(list(PANELS.values()), table)
    assert [axes.get_title() for axes in figure.axes if axes.get_visible()] == [panel.name]
    assert "1 refused with a reason" in figure.get_suptitle()
