"""Scenes far from the usual: a run keeps its accuracy, states that it does not, or is refused."""

import tomllib
import warnings
from itertools import product
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

FOLDER = Path(__file__).parent / "extreme_scenes"
PANELS = tomllib.loads((FOLDER / "panels.toml").read_text("utf-8"))
CELLS = tomllib.loads((FOLDER / "cells.toml").read_text("utf-8"))
FORMULAS = {
    "x": lambda x: x,
    "0.5 + x": lambda x: 0.5 + x,
    "1 - x": lambda x: 1 - x,
    "(1 - x) / 2": lambda x: (1 - x) / 2,
    "1 / x, from 5 to 40": lambda x: int(np.clip(round(1 / x), 5, 40)),
}
# greatest ratio of an error to its estimate that still counts as stated
STATED = 3.0


def value_at(x, template):
    """Return a value of a scene key at x: texts of `FORMULAS` become numbers."""
    if isinstance(template, str):
        return FORMULAS[template](x) if template in FORMULAS else template
    if isinstance(template, dict):
        return {key: value_at(x, value) for key, value in template.items()}
    return [value_at(x, value) for value in template] if isinstance(template, list) else template


def scene_of(panel, x, solver):
    """Return the scene of a panel at a value; sizes of other methods are left out."""
    section = {"fem": "accuracy.fem.", "mdr": "accuracy.mdr.", "bem": "accuracy.mdr."}.get(solver)
    base = Scene.from_table(PANELS["base"]).changed(**panel.get("scene", {}))
    changes = {
        key: value_at(x, value)
        for key, value in panel.get("changes", {}).items()
        if not key.startswith(("accuracy.fem.", "accuracy.mdr.")) or f"{section}" in key
    }
    return base.changed(changes)


IN_PANELS = {panel["name"]: panel for panel in PANELS["panels"]}


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
@pytest.mark.parametrize("name", nightly_but([*IN_PANELS][::4], IN_PANELS))
def test_methods_keep_their_accuracy_where_the_naive_choice_fails(name):
    panel, verdicts = IN_PANELS[name], []
    x = panel["fails_at"]
    for solver in panel.get("methods", ("mdr", "bem", "fem")):
        if "," in solver:
            continue
        scene = scene_of(panel, x, solver)
        case, record = Case.of(scene), Record()
        table = measure(
            [case],
            [watched(tolerances(method(solver), [case.problem.rtol]))],
            DEFAULT,
            record,
            exact=lambda case: reference(case, rtol=0.01 * case.problem.rtol, confirmed=False),
            only_promised=True,
        )
        allowed = scene.accuracy.rtol * (1 if case.problem.full_contact else 2)
        verdicts += [judge(row, allowed) for row in table.to_dict("records")]
    assert not {"wrong", "crashed"} & set(verdicts), verdicts
    if panel["name"] != "step of the march":
        assert "within" in verdicts


def far_value(axis):
    """Return an extreme value of an axis: the one at 70 % of its length."""
    values = list(axis)
    return values[int(0.7 * (len(values) - 1) + 0.5)]


def read_axis(axis):
    """Return the changes of scene keys for each value, or each label, of an axis."""
    axis = CELLS["axes"][axis] if isinstance(axis, str) else axis
    key, values = next(iter(axis.items()))
    if "." not in key:
        return axis
    if isinstance(values, dict):
        values = [float(f"{value:.9g}") for value in np.geomspace(*values["geomspace"])]
    return {value: {key: [value] if key == "wear.times" else value} for value in values}


def cells():
    """Yield family, method, values and scene of all cells."""
    base = Scene.from_table(CELLS["base"])
    for family in CELLS["families"]:
        x_axis, y_axis = (read_axis(family[axis]) for axis in "xy")
        for x, y, solver in product(x_axis, y_axis, family["methods"]):
            changes = {"accuracy.rtol": CELLS["rtol"][solver]}
            changes |= family.get("scene", {}) | x_axis[x] | y_axis[y]
            yield family, solver, x, y, changes, base, far_value(x_axis), far_value(y_axis)


def verdict_on(scene, solver):
    """Return the worst verdict on the steady state and on the anchors of a run."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            result = run(scene, list(dict.fromkeys([solver, "direct"])))
            rows = [(each.difference, each.uncertainty, 0.0) for each in result.agreement]
            rows += [(each.difference, each.tolerance, each.tolerance) for each in result.anchors]
    except RingwearError:
        return "refused"
    rtol = scene.accuracy.rtol
    wrong = [
        difference > max(rtol, tolerance, STATED * stated) for difference, stated, tolerance in rows
    ]
    assert rows
    return "wrong" if any(wrong) else "within"


LISTED = list(cells())
QUICK = {
    (family["name"], solver): (changes, base)
    for family, solver, x, y, changes, base, far_x, far_y in LISTED
    if (x, y) == (far_x, far_y) and not family.get("slow")
}


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("cell", QUICK, ids=lambda cell: ", ".join(cell))
def test_an_extreme_cell_of_each_family_is_right_or_refused(cell):
    changes, base = QUICK[cell]
    try:
        scene = base.changed(changes)
    except RingwearError:
        return
    assert verdict_on(scene, cell[1]) in ("within", "refused")


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
    (scene,) = (
        base.changed(changes)
        for family, solver, x, y, changes, base, *_ in LISTED
        if (family["name"], x, y) == place and solver == "mdr"
    )
    result = run(scene, ["mdr", "direct"])
    for row in result.agreement:
        assert row.difference <= row.uncertainty, row.quantity
    if len(scene.problem.times):
        solution = method("mdr").solve(scene.problem, Stages("mdr"))
        start = abs(solution.results["indentation"][0] / 0.5 - 1)
        assert start <= solution.errors["indentation"][0]


def test_the_lists_are_long():
    assert len(IN_PANELS) == 20
    assert len(LISTED) > 2000
    assert {"direct", "mdr", "fem"} == {solver for _, solver, *_ in LISTED}
