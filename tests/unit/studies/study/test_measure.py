"""The table of levels: rows on disk at once, levels that fail, resumed studies, and progress."""

import csv
import itertools
import logging

import numpy as np
import pytest

from ringwear import Scene, Solution, SolverError
from ringwear.studies.study.measure import measure
from ringwear.studies.study.record import COLUMNS, Record
from ringwear.studies.study.reference import Reference
from ringwear.studies.study.study import remarks
from ringwear.studies.study.way import OTHERS, Case, Theory, Way

CASE = Case.of(Scene.load("flat_punch").changed(wear__times=[0.0, 0.1]))
EXACT = {"time": np.array([0.0, 0.1]), "indentation": np.array([0.5, 0.6])}
SIZES = (0.5, 0.3, 0.2, 0.1)


def solution(size, unknowns=10):
    """Return a solution whose indentation errs by the square of a size, at both times."""
    compared = EXACT | {"indentation": EXACT["indentation"] * (1 + size**2)}
    errors = {"indentation": np.full(2, 2 * size**2)}
    return Solution(compared, compared, errors, {}, unknowns)


def exact(_):
    return Reference(EXACT, lambda _: 0.0)


def way(solve=lambda _, size: solution(size), levels=SIZES, **more):
    return Way("h", "fem", levels, solve, "size", float, {OTHERS: Theory(2.0)}, **more)


def measured(record, *ways, **more):
    return measure([CASE], ways, ("indentation",), record, exact=exact, **more)


def rows(file):
    return list(csv.DictReader(file.read_text("utf-8").splitlines()))


def test_a_level_has_a_row_for_each_quantity_and_time():
    table = measured(Record(), way())
    assert list(table) == list(COLUMNS)
    assert list(table)[:3] == ["case", "way", "method"]
    assert table["when"].tolist() == ["start", "later"] * 4
    assert table["error"].tolist() == pytest.approx([size**2 for size in SIZES for _ in "12"])
    assert table["estimate"].tolist() == pytest.approx((2 * table["error"]).tolist())
    # three levels that converge exactly give the limit and an index of 1.25 times the error
    start, later = table.iloc[-2], table.iloc[-1]
    assert [start["limit"], later["limit"]] == pytest.approx([0, 0], abs=1e-12)
    # the index of a number is relative to the finest value, that of a norm to the exact one
    assert [start["index"], later["index"]] == pytest.approx([1.25 * 0.01 / 1.01, 1.25 * 0.01])
    assert table["index"].isna().sum() == 4


@pytest.mark.parametrize("error", [SolverError("singular"), ZeroDivisionError("nothing")])
def test_a_level_that_fails_is_a_row_and_ends_its_way(error):
    def solve(_, size):
        if size == 0.3:
            raise error
        return solution(size)

    record = Record()
    table = measured(record, way(solve))
    failed = table.iloc[-1]
    assert table["level"].unique().tolist() == ["0.5", "0.3"]
    outcome = "refused" if isinstance(error, SolverError) else "crashed"
    assert failed["outcome"] == outcome
    assert str(error) in failed["message"]
    (remark,) = remarks(record)
    assert remark.startswith(f"scene, h, level 0.3 {outcome}")


def test_a_resumed_study_keeps_rows_and_solves_the_others(tmp_path):
    whole = Record(tmp_path / "whole.csv")
    measured(whole, way())
    lines = whole.file.read_text("utf-8").splitlines(keepends=True)
    # the process was killed while it wrote the last line
    text = "".join(lines[:7]) + lines[7][:20]
    solved = []

    def solve(_, size):
        solved.append(size)
        return solution(size)

    record = Record.resumed(text, tmp_path / "resumed.csv")
    table = measured(record, way(solve))
    # the two levels before a new one are solved again, because extrapolation needs them
    assert solved == [0.3, 0.2, 0.1]
    again = rows(tmp_path / "resumed.csv")
    before = rows(whole.file)
    seconds = ("seconds",)
    assert again[:6] == before[:6]
    for new, old in zip(again[6:], before[6:], strict=True):
        assert {k: v for k, v in new.items() if k not in seconds} == {
            k: v for k, v in old.items() if k not in seconds
        }
    assert len(table) == 8
    solved.clear()
    measured(Record.resumed("".join(lines), None), way(solve))
    assert not solved


def test_a_sequential_way_starts_from_the_level_before():
    def solve(_, level, previous):
        assert (previous is None) == (level == 0)
        return solution(0.5**level, 100 * 2**level)

    table = measured(Record(), way(solve, range(4), sequential=True))
    assert table["unknowns"].unique().tolist() == [100, 200, 400, 800]
    # its seconds include those of all levels before
    assert table["seconds"].is_monotonic_increasing


def test_progress_prints_the_level(caplog):
    with caplog.at_level(logging.INFO, logger="ringwear"):
        measured(Record(), way())
    lines = [record.getMessage() for record in caplog.records]
    assert lines[0].startswith("   level 1 of 4: scene, h, 0.5")
    assert lines[2].startswith("   level 3 of 4: ")


def test_seconds_are_medians_of_several_runs(monkeypatch):
    clock = itertools.chain([0.0], *([n, n + s] for n, s in ((0.0, 5.0), (5.0, 1.0), (6.0, 2.0))))
    from ringwear.studies.study import measure as module

    monkeypatch.setattr(module.time, "process_time", lambda: next(clock))
    table = measured(Record(), way(levels=(0.5,)), runs=3)
    first = table.iloc[0]
    assert (first["seconds"], first["least seconds"], first["greatest seconds"]) == (2.0, 1.0, 5.0)
