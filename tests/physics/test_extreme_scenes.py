"""Scenes far from the usual: a run keeps its accuracy, states that it does not, or is refused."""

import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest
from groups import nightly_but

from ringwear import RingwearError, Scene, Stages, method, run
from ringwear.studies.extremes import watched
from ringwear.studies.study.errors import DEFAULT
from ringwear.studies.study.measure import measure
from ringwear.studies.study.record import Record
from ringwear.studies.study.reference import reference
from ringwear.studies.study.way import Case
from ringwear.studies.study.ways.runs import tolerances

LISTS = tomllib.loads((Path(__file__).parent / "extreme_scenes.toml").read_text("utf-8"))
BASE = Scene.from_table(LISTS["base"])
KEYS, PAIRS, NARROW = (
    {row["name"]: row for row in LISTS[kind]} for kind in ("keys", "pairs", "narrow")
)
# greatest ratio of an error to its estimate that still counts as stated
STATED = 3.0


def judge(row, allowed):
    """Return the verdict on a row of a table of levels."""
    if row["outcome"] != "solved":
        return row["outcome"]
    size = abs(row["error"])
    if np.isnan(size) or size <= allowed:
        return "within"
    return "degraded" if size <= STATED * row["estimate"] else "wrong"


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("name", nightly_but([*KEYS][::4], KEYS))
def test_methods_keep_their_accuracy_where_the_naive_choice_fails(name):
    scene, verdicts = BASE.changed(KEYS[name]["changes"]), []
    allowed = scene.accuracy.rtol * (1 if scene.problem.full_contact else 2)
    for solver in KEYS[name].get("methods", ("mdr", "bem", "fem")):
        case, record = Case.of(scene), Record()
        table = measure(
            [case],
            [watched(tolerances(method(solver), [case.problem.rtol]))],
            DEFAULT,
            record,
            exact=lambda case: reference(case, rtol=0.01 * case.problem.rtol, confirmed=False),
            only_promised=True,
        )
        verdicts += [judge(row, allowed) for row in table.to_dict("records")]
    assert not {"wrong", "crashed"} & set(verdicts), verdicts
    assert KEYS[name].get("verdict", "within") in verdicts


def verdict_on(scene, solver):
    """Return the worst verdict on the steady state and on the anchors of a run."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        result = run(scene, list(dict.fromkeys([solver, "direct"])))
        rows = [(each.difference, each.uncertainty, 0.0) for each in result.agreement]
        rows += [(each.difference, each.tolerance, each.tolerance) for each in result.anchors]
    rtol = scene.accuracy.rtol
    wrong = [
        difference > max(rtol, tolerance, STATED * stated) for difference, stated, tolerance in rows
    ]
    assert rows
    return "wrong" if any(wrong) else "within"


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("name", nightly_but([*PAIRS][::2], PAIRS))
def test_two_extreme_values_give_a_right_result_or_a_refusal(name):
    for solver in PAIRS[name]["methods"]:
        try:
            verdict = verdict_on(BASE.changed(PAIRS[name]["changes"]), solver)
        except RingwearError:
            verdict = "refused"
        assert verdict == PAIRS[name].get("outcome", "within"), solver


@pytest.mark.parametrize("name", NARROW)
def test_estimates_hold_where_rings_limit_the_mesh(name):
    scene = BASE.changed(NARROW[name]["changes"])
    result = run(scene, ["mdr", "direct"])
    for row in result.agreement:
        assert row.difference <= row.uncertainty, row.quantity
    if len(scene.problem.times):
        solution = method("mdr").solve(scene.problem, Stages("mdr"))
        start = abs(solution.results["indentation"][0] / 0.5 - 1)
        assert start <= solution.errors["indentation"][0]
