"""Scenes at the limits of what can be computed: no verdict is false, and errors are as stated."""

import json
from functools import partial

import pandas as pd
import pytest

from ringwear import Scene, run
from ringwear.studies.numerics import extremes


def cells(quick):
    """Return what solves each cell of the map of limits, by family, method, x and y."""
    return {
        (family.name, *cell): partial(family.solve, cell)
        for family in extremes.families(0.3, quick)
        for cell in family.sizes
    }


@pytest.mark.slow
def test_a_quick_cell_of_each_family_and_method_is_judged():
    chosen = {cell[:2]: (cell[0], solve) for cell, solve in cells(quick=True).items()}
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
    row = cells(quick=False)[place[0], "mdr", *place[1:]]()
    assert row["error"] <= row["estimate"]
    pressed = run(Scene.from_table(json.loads(row["parameters"])), ["mdr"]).dataset
    if pressed.sizes["time"]:
        start = pressed.sel(solver="mdr", time=0)
        assert abs(start.indentation / 0.5 - 1) <= start.indentation_error
