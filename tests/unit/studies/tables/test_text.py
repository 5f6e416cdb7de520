"""Tables of other programs: names and units in headings, and numbers that are read at once."""

import numpy as np
import pandas as pd
import pytest

from ringwear.studies.check.columns import our_name
from ringwear.studies.tables.text import read_numbers, read_texts, split_heading


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        ("time", ("time", "")),
        ("Time [s]", ("time", "s")),
        ("t", ("time", "")),
        ("R (mm)", ("radius", "mm")),
        ("p / MPa", ("pressure", "MPa")),
        ("Contact pressure [MPa]", ("pressure", "MPa")),
        ("Normal Force", ("normal_force", "")),
        ("wear coefficient [mm^3/(N m)]", ("wear_coefficient", "mm^3/(N m)")),
    ],
)
def test_headings_are_known_in_any_case_by_symbols_and_with_units(heading, expected):
    assert (our_name(heading), split_heading(heading)[1]) == expected


def test_large_files_are_read_fast_and_like_small_ones(tmp_path):
    path = tmp_path / "theirs.csv"
    table = pd.DataFrame({"time": 0.0, "radius": np.linspace(0, 1, 500), "pressure": 2.0})
    table.to_csv(path, index=False)
    plain = path.read_text("utf-8")
    head, _, rows = plain.partition("\n")
    texts = [
        plain,
        "# a remark\n\n" + plain,
        "% a remark\n% time,radius,pressure\n" + rows,
        f"{head}\ns,m,Pa\n{rows}",
        plain.replace(",", " "),
        plain.replace(",", ";").replace(".", ","),
    ]
    for text in texts:
        path.write_text(text, "utf-8")
        at_once = read_numbers(path)
        by_lines = read_texts(path, text).astype(float)
        pd.testing.assert_frame_equal(at_once, by_lines)
    for line in ("0,0.5\n", "0,0.5,much\n", "# a remark\n", "\n"):
        path.write_text(plain + line, "utf-8")
        assert read_numbers(path) is None
