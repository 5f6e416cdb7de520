"""The study of extremes: its verdicts, its families, and closed forms of the start."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from ringwear.studies.extremes import cells as of_map
from ringwear.studies.extremes.oracles import (
    start_in_closed_form,
)
from ringwear.studies.extremes.panels import METHODS, NAIVE, read_panels
from ringwear.studies.extremes.verdicts import (
    verdict_on,
    verdict_on_promise,
    worst_of,
)
from ringwear.studies.tables import Row

Solve = Callable[[], Row]
PANELS = {panel.name: panel for panel in read_panels(0.3)}


def cells(quick):
    """Return functions that solve each cell, by family, method, x and y."""
    listed = [
        ((family.name, *cell), partial(family.solve, cell))
        for family in of_map.families(0.3, quick)
        for cell in family.sizes
    ]
    # no cell occurs twice
    assert len(dict(listed)) == len(listed)
    return dict(listed)


ALL, QUICK = cells(quick=False), cells(quick=True)


@pytest.mark.parametrize(
    ("error", "estimate", "verdict"),
    [
        (1e-4, 2e-4, "within"),
        (0.05, 0.1, "degraded"),
        (5e-4, 1e-6, "degraded"),
        (2e-3, 1e-3, "degraded"),
        (0.1, 1e-3, "wrong"),
        (np.nan, 1e-3, "wrong"),
    ],
)
def test_verdicts(error, estimate, verdict):
    assert verdict_on("indentation", error, estimate, 1e-3)["verdict"] == verdict


@pytest.mark.parametrize(
    ("error", "estimate", "verdict"),
    [
        # the error is below rtol, whatever the estimate
        (5e-4, 1e-6, "within"),
        (5e-4, 1.0, "within"),
        (2e-3, 1e-3, "degraded"),
        (0.1, 1.0, "degraded"),
        (4e-3, 1e-3, "wrong"),
        (np.nan, 1e-3, "wrong"),
    ],
)
def test_verdicts_on_a_promise(error, estimate, verdict):
    assert verdict_on_promise("indentation", error, estimate, 1e-3)["verdict"] == verdict


def test_the_worst_quantity_of_a_run_is_reported():
    judged = [verdict_on("a", 1e-5, 1e-4, 1e-3), verdict_on("b", 0.1, 1e-4, 1e-3)]
    assert worst_of(lambda: judged)["quantity"] == "b"
    # a run without any judged quantity counts as crashed
    assert worst_of(lambda: [])["verdict"] == "crashed"


def test_every_method_has_its_cells():
    assert {"direct", "mdr", "fem"} == {method for _, method, *_ in ALL}
    assert {family for family, *_ in QUICK} == {family for family, *_ in ALL}
    assert len(ALL) > 2000 > 500 > len(QUICK)


def test_a_step_that_is_unstable_is_refused():
    unstable = ALL["step × march", "mdr", 100.0, "explicit"]()
    assert unstable["verdict"] == "refused"
    assert "unstable" in unstable["message"]


def test_an_unexpected_exception_is_a_crash(monkeypatch):
    monkeypatch.delattr(of_map, "run")
    row = next(iter(QUICK.values()))()
    assert row["verdict"] == "crashed"
    assert "NameError" in row["message"]


def test_every_panel_has_its_runs():
    parameters = """wear ratio|width ratio of 5 rings|number of rings|narrow disc at the axis|
        narrow ring between others|narrow ring at the rim|Poisson's ratio|truncation|
        smallest element|degree|first time|last time|step of the march|accuracy asked for|
        unit of length|sphere|cone|force that rises|fixed indentation, last time|hollow punch"""
    assert {name.strip() for name in parameters.split("|")} == PANELS.keys()
    for panel in PANELS.values():
        for quick, values in ((True, panel.quick), (False, panel.values)):
            runs = panel.family(quick).sizes
            methods = [name for name in panel.methods if not (quick and name == "bem")]
            assert runs.keys() == {(x, name) for x in values for name in (*methods, NAIVE)}
        assert panel.fails_at in panel.quick
    assert set(METHODS) == {name for panel in PANELS.values() for name in panel.methods} & {
        "mdr",
        "bem",
        "fem",
    }


def test_starts_in_closed_form():
    """Hertz: F = 4/3 E* sqrt(R) d^(3/2); cone: F = 2 E* d^2 / (pi s); d in units of F / (a E*)."""
    sphere = PANELS["sphere"].scene(3.0, "mdr")
    start, force = start_in_closed_form(sphere), 0.01
    depth = start["indentation"] * force
    assert 4 / 3 * 3.0**0.5 * depth**1.5 == pytest.approx(force, rel=1e-12)
    assert start["contact_radius"] == pytest.approx((3.0 * depth) ** 0.5, rel=1e-12)
    cone = start_in_closed_form(PANELS["cone"].scene(0.1, "mdr"))
    depth = cone["indentation"] * force
    assert 2 * depth**2 / (np.pi * 0.1) == pytest.approx(force, rel=1e-12)
    # no closed form if the whole face of the sphere is in contact, or if the force varies
    assert not start_in_closed_form(PANELS["sphere"].scene(1e6, "mdr"))
    assert not start_in_closed_form(PANELS["force that rises"].scene(10.0, "mdr"))


def test_an_impossible_scene_is_a_refusal_with_its_message():
    row = PANELS["degree"].family(quick=False).solve((17, "fem"))
    assert row["verdict"] == "refused"
    assert "accuracy.fem.degree" in row["message"]
