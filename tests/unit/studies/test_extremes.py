"""The map of limits: its verdicts, and that every family can be asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

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


def test_a_step_that_is_unstable_is_refused():
    unstable = ALL["step × march", "mdr", 100.0, "explicit"]()
    assert unstable["verdict"] == "refused"
    assert "unstable" in unstable["message"]


def test_an_unexpected_exception_is_a_crash(monkeypatch):
    monkeypatch.delattr(extremes, "run")
    row = next(iter(QUICK.values()))()
    assert row["verdict"] == "crashed"
    assert "NameError" in row["message"]
