"""Levels of a study: rows that are on disk at once, progress, and the time that is left."""

import csv
import logging

import numpy as np
import pytest

from ringwear.studies.study.levels import Family, Progress, Record


def test_rows_are_on_disk_at_once_and_kept_on_interruption(tmp_path):
    def solve(setting):
        if setting == 1:
            return {"b": "x"}
        (row,) = csv.DictReader((tmp_path / "t.csv").read_text("utf-8").splitlines())
        assert row["setting"] == "1"
        assert row["b"] == "x"
        assert float(row["seconds"]) >= 0
        assert float(row["peak MiB"]) > 10
        raise KeyboardInterrupt

    record = Record(tmp_path)
    family = Family("h", {1: np.nan, 2: np.nan}, solve)
    table = record.solve("t", [family], ["setting", "b"])
    assert table.setting.tolist() == [1]
    (conclusion,) = record.conclusions
    assert "rows that were finished" in conclusion


def test_progress_prints_the_level_and_the_time_left(caplog):
    family = Family("h", {1: 1.0, 2: 0.5, 3: 0.25}, lambda _: {"value": 1.0})
    with caplog.at_level(logging.INFO, logger="ringwear"):
        Record().solve("t", [family], ["family", "setting", "size", "value"])
    lines = [record.getMessage() for record in caplog.records]
    assert lines[0].startswith("   level 1 of 3: h, 1")
    assert lines[2].startswith("   level 3 of 3, about ")


def test_time_left_follows_from_the_seconds_of_earlier_levels():
    progress = Progress([1.0, 3.0, 6.0])
    progress.finish(2.0)
    assert progress.seconds_left == pytest.approx(18.0)
    progress.finish(6.0)
    assert progress.seconds_left == pytest.approx(12.0)
