"""The map of limits: its verdicts, and that every family can be asked for."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, run
from ringwear.studies.numerics import extremes
from ringwear.studies.tables import Row

Solve = Callable[[], Row]


def cells(quick):
    """Every cell by family, method, x and y."""
    listed = [
        ((family.name, *cell), partial(family.solve, cell))
        for family in extremes.families(0.3, quick)
        for cell in family.sizes
    ]
    assert len(dict(listed)) == len(listed)  # none comes twice
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
    assert extremes.verdict_on("indentation", error, estimate, 1e-3)["verdict"] == verdict


def test_every_method_has_its_cells():
    assert {"direct", "mdr", "fem"} == {method for _, method, *_ in ALL}
    assert {family for family, *_ in QUICK} == {family for family, *_ in ALL}
    assert len(ALL) > 2000 > 500 > len(QUICK)


@pytest.mark.slow
def test_a_quick_cell_of_each_family_and_method_is_judged():
    chosen = {cell[:2]: (cell[0], solve) for cell, solve in QUICK.items()}
    rows = [{"family": family} | solve() for family, solve in chosen.values()]
    assert not {"wrong", "crashed"} & {row["verdict"] for row in rows}
    figure = extremes.draw(pd.DataFrame(rows))
    assert len(figure.axes) == len(chosen)


@pytest.mark.parametrize(
    "place",
    [
        # the layer of these is set by the width of the ring, not by the size asked for
        *(("rim_size/a × degree", 0.5, degree) for degree in (8, 12, 16)),
        *(("ring_size/a × degree", 0.5, degree) for degree in (4, 12, 16)),
        ("h2/h1 × k2/k1", 0.01, 1e-8),
        # relaxation times span more than the digits of an eigenvalue
        ("h2/h1 of 3 rings × k2/k1", 2.1e-9, 1e8),
    ],
)
def test_estimates_hold_where_rings_limit_the_mesh(place):
    row = ALL[place[0], "mdr", *place[1:]]()
    assert row["error"] <= row["estimate"]
    pressed = run(Scene.from_table(json.loads(row["parameters"])), ["mdr"]).dataset
    if pressed.sizes["time"]:
        start = pressed.sel(solver="mdr", time=0)
        assert abs(start.indentation / 0.5 - 1) <= start.indentation_error


def test_a_step_that_is_unstable_is_refused():
    unstable = ALL["step × march", "mdr", 100.0, "explicit"]()
    assert unstable["verdict"] == "refused"
    assert "unstable" in unstable["message"]


def test_an_unexpected_exception_is_a_crash(monkeypatch):
    monkeypatch.delattr(extremes, "run")
    row = next(iter(QUICK.values()))()
    assert row["verdict"] == "crashed"
    assert "NameError" in row["message"]
