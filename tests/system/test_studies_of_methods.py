"""The quick studies of marches, and of error against seconds."""

from __future__ import annotations

import argparse
import csv
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from ringwear import Scene
from ringwear.studies import time_steps, tradeoff
from ringwear.studies.convergence.orders import VERDICT

Rows = list[dict[str, str]]


def conducted(study: Any, out: Path) -> dict[str, Rows]:
    """Rows of each table of a quick study."""
    study.conduct(Scene.load("five_rings"), out, argparse.Namespace(quick=True))
    assert {file.suffix for file in out.iterdir()} == {".csv", ".md", ".png"}
    return {
        file.stem: list(csv.DictReader(file.read_text("utf-8").splitlines()))
        for file in out.glob("*.csv")
    }


def test_march(tmp_path: Path) -> None:
    tables = conducted(time_steps, tmp_path)
    assert [row[VERDICT] for row in tables["orders"]] == ["yes"] * 4
    for row in tables["limits"]:
        assert float(row["ratio"]) == pytest.approx(
            1, abs=0.15 if row["theory"] == "4/(pi n k)" else 0.01
        )


@pytest.mark.gmsh
def test_tradeoff(tmp_path: Path) -> None:
    tables = conducted(tradeoff, tmp_path)
    measured = [row for row in tables["tradeoff"] if not row["remark"]]
    assert {row["family"] for row in measured} >= {
        "mdr",
        "bem",
        "fem quads",
        "fem P4",
        "mdr implicit",
        "mdr-grid",
    }
    for row in tables["dial"]:
        assert float(row["error"]) <= float(row["setting"].removeprefix("rtol "))
    front = tables["front"]
    assert all(float(better["error"]) < float(fast["error"]) for fast, better in pairwise(front))
    for row in measured:
        fastest = [one for one in front if float(one["seconds"]) <= float(row["seconds"])][-1]
        assert float(fastest["error"]) <= 1.2 * float(row["error"])
