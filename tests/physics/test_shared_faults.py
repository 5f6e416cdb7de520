"""Anchors notice faults that two methods share, in scenes of every kind.

The matrix in `faults/matrix.csv` tells which anchors notice which fault. A new anchor has to earn
its place: it notices a fault that no other anchor notices. If none of the faults is of its kind,
add one to `faults/`.
"""

from collections import Counter
from pathlib import Path

import pandas as pd
import pytest
from faults import computed, pipeline, reported
from faults.scenes import SCENES, healthy, shared, with_results, with_table

FAULTS = [
    (kind, place, name, fault)
    for kind in SCENES
    for place, of in (("reported", reported), ("computed", computed), ("pipeline", pipeline))
    # under a rising load, faults of computed results are the same as in the flat scene
    if (kind, place) != ("rising", "computed")
    for name, fault in of.faults(kind)
]
# scenes in full contact and with moving edges are two kinds; all others are for the night
MARKS = {"flat": [], "sphere": [pytest.mark.slow]}
NAMES = [f"{kind}, {place}: {name}" for kind, place, name, _ in FAULTS]


def with_fault(patch, kind, place, fault):
    """Return the result of a scene of a kind with a fault in its table, its results or the code."""
    if place == "pipeline":
        fault(patch)
        # a new scene, because a fault may change the problem, which a scene caches
        return shared(SCENES[kind].changed())
    return (with_table if place == "reported" else with_results)(healthy(kind), fault)


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=MARKS.get(kind, pytest.mark.nightly)) for kind in SCENES]
)
def test_anchors_hold_without_a_fault(kind):
    result = healthy(kind)
    assert [anchor for anchor in result.anchors if not anchor.holds] == []
    assert result.verdict == "agree"


# anchors may divide by damaged numbers
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    ("kind", "place", "fault"),
    [
        pytest.param(kind, place, fault, marks=MARKS.get(kind, pytest.mark.nightly))
        for kind, place, _, fault in FAULTS
    ],
    ids=NAMES,
)
def test_a_fault_is_noticed(monkeypatch, kind, place, fault):
    assert with_fault(monkeypatch, kind, place, fault).verdict != "agree"


def test_every_fault_is_tried_once():
    assert max(Counter(NAMES).values()) == 1
    assert len(FAULTS) >= 184


FILE = Path(__file__).parent / "faults" / "matrix.csv"


def broken_by(kind, place, fault):
    """Return the anchors that do not hold with a fault, without the numbers in their names."""
    with pytest.MonkeyPatch.context() as patch:
        wrong = with_fault(patch, kind, place, fault)
        return {anchor.name for anchor in wrong.anchors if not anchor.holds}


# anchors may divide by damaged numbers
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.nightly
def test_a_new_anchor_notices_a_fault_that_no_other_notices():
    noticed = {
        f"{kind}, {place}: {name}": broken_by(kind, place, fault)
        for kind, place, name, fault in FAULTS
    }
    known = pd.read_csv(FILE)["anchor"].unique() if FILE.exists() else []
    rows = [(fault, anchor) for fault, anchors in noticed.items() for anchor in sorted(anchors)]
    alone = {anchor for anchors in noticed.values() if len(anchors) == 1 for anchor in anchors}
    new = {anchor for _, anchor in rows}.difference(known) if len(known) else set()
    assert new <= alone
    pd.DataFrame(rows, columns=["fault", "anchor"]).to_csv(FILE, index=False)
