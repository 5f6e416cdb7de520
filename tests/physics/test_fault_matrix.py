"""Which anchors notice which fault: the matrix in `faults/matrix.csv`.

A new anchor has to earn its place: it notices a fault that no other anchor notices. If none of the
faults is of its kind, add one to `faults/`.
"""

from pathlib import Path

import pandas as pd
import pytest
from test_shared_faults import FAULTS, with_fault

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
    pd.DataFrame(rows, columns=["fault", "anchor"]).to_csv(FILE, index=False)
    alone = {anchor for anchors in noticed.values() if len(anchors) == 1 for anchor in anchors}
    new = {anchor for _, anchor in rows}.difference(known) if len(known) else set()
    assert new <= alone
