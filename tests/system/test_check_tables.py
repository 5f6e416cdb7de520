"""Tables of other programs in any form: headings, separators, units, one verdict for each."""

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, SceneError, check

SCENE = Scene(
    units="SI",
    methods=["mdr"],
    punch={"radius": 0.01, "rings": 1, "wear_coefficients": [1e-15]},
    half_space={"plane_strain_modulus": 2e9},
    load={"normal_force": 100.0, "sliding_speed": 0.1},
    wear={"times": [0.0, 10.0]},
)
DEPTH = 100 / (2 * 0.01 * 2e9)
"""Indentation of the flat start, F / (2 a E*), in metres."""
RADII = np.array([0.0, 2.5, 5.0, 7.5])
"""In millimetres."""


@pytest.mark.parametrize(
    ("headings", "columns"),
    [
        ("time [s],depth [um]", {"depth": "indentation"}),
        ("time [s],Depth [um]", {"depth": "indentation"}),
        ("time [s],sensor 1 (um)", {"Sensor 1": "indentation"}),
        ("time [s],sensor/um", {"sensor/um": "indentation"}),
        ("clock [s],depth [um]", {"clock": "time"}),
        ("time,depth\ns,um", {"depth": "indentation"}),
        ("time [s],indentation [mm],sensor [um]", {"indentation": "raw", "sensor": "indentation"}),
    ],
)
def test_a_column_is_named_without_the_unit_in_its_heading(headings, columns, tmp_path):
    """The unit in the heading counts, whatever the user calls the column."""
    cells = ["0", *["7"] * (headings.split("\n")[0].count(",") - 1), f"{1e6 * DEPTH:.12g}"]
    path = tmp_path / "theirs.csv"
    path.write_text(f"{headings}\n{','.join(cells)}\n", "utf-8")
    (row,) = check(SCENE, path, columns=columns).rows
    assert row.quantity == "indentation"
    assert abs(row.error) <= row.stated + 1e-11


def test_a_column_that_a_table_does_not_have_is_named_with_its_headings(tmp_path):
    path = tmp_path / "theirs.csv"
    path.write_text("time [s],Depth [um]\n0,1\n", "utf-8")
    with pytest.raises(SceneError, match=r"no column 'deep'; its columns are time \[s\], Depth"):
        check(SCENE, path, columns={"deep": "indentation"})


def test_a_unit_of_another_kind_is_refused_with_its_heading(tmp_path):
    path = tmp_path / "theirs.csv"
    path.write_text("time [s],indentation [MPa]\n0,0.1\n", "utf-8")
    with pytest.raises(SceneError, match=r"heading of indentation: 'MPa' is no unit"):
        check(SCENE, path)


def test_one_table_needs_no_name_and_errors_are_a_table():
    table = pd.DataFrame({"time": [0.0], "indentation": [0.97 * DEPTH]})
    checked = check(SCENE, table)
    assert checked.errors.solver.tolist() == ["theirs"]
    (error,), (stated,) = checked.errors.error, checked.errors.stated
    assert abs(error + 0.03) <= stated
    assert not checked.passes


@pytest.mark.slow
def test_files_of_different_programs_have_separate_verdicts_and_are_no_refinement(command):
    for name, factor in (("abaqus", 1.001), ("ansys", 0.9)):
        table = pd.DataFrame({"time": [0.0], "indentation": [factor * DEPTH]})
        table.to_csv(f"{name}.csv", index=False)
    output = command("check scene.toml abaqus.csv ansys.csv --out out", 3, SCENE).out
    assert "abaqus.csv: all 1 quantities are within 0.01 of ours" in output
    assert "ansys.csv: 1 of 1 quantities differ from ours by more than 0.01: indentation" in output
    assert "order" not in output
    output = command("check scene.toml ansys.csv abaqus.csv --refinement --out out").out
    assert "refinement: indentation" in output


def test_large_errors_are_printed_as_multiples():
    table = pd.DataFrame({"time": [0.0], "indentation": [1e6 * DEPTH]})
    (_, line, *_) = check(SCENE, table).texts.lines
    assert "1e+06 times too high" in line
    assert "%" not in line.partition("(")[0]


@pytest.mark.slow
def test_a_column_of_nan_is_refused_and_an_empty_one_reported(tmp_path, caplog):
    """A program that has failed may write a table of NaN; an empty column was not filled in."""
    rows = pd.DataFrame({"time": 0.1, "radius": [0.1, 0.3, 0.5], "profile": 0.05})
    path = tmp_path / "failed.csv"
    rows.assign(pressure=np.nan).to_csv(path, index=False, na_rep="NaN")
    with pytest.raises(SceneError, match="column 'pressure' has no numbers but NaN"):
        check("five_rings", path)
    rows.assign(pressure=np.nan).to_csv(path, index=False)
    for source in (path, rows.assign(pressure=np.nan)):
        with caplog.at_level("WARNING", logger="ringwear"):
            check("five_rings", source)
        assert "has no numbers in: pressure" in caplog.text
        caplog.clear()


@pytest.mark.slow
def test_gaps_in_a_column_are_reported(caplog):
    rows = pd.DataFrame({"time": 0.1, "radius": [0.1, 0.3, 0.5], "profile": 0.05})
    with caplog.at_level("WARNING", logger="ringwear"):
        check("five_rings", rows.assign(pressure=[0.4, np.nan, np.nan]))
    assert "2 rows of fields have no pressure" in caplog.text


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ({"mine": 1.0}, "is no table: give a file"),
        ({"mine": [0.1, 0.2]}, "no column 'time'"),
    ],
)
def test_what_is_no_table_is_refused_in_one_line(source, message):
    with pytest.raises(SceneError, match=message):
        check("five_rings", source)


@pytest.mark.slow
@pytest.mark.parametrize(
    "columns", [["displacement"], ["displacement", "indentation"], ["indentation", "profile"]]
)
def test_mistakes_are_tried_in_tables_of_any_columns(columns):
    """Among them is a layer, which loses contact or not, depending on its thickness."""
    punch = {"radius": 0.01, "rings": 3, "wear_coefficients": [1e-15, 1e-14]}
    values = {"displacement": 0.8 * DEPTH, "indentation": 0.8 * DEPTH, "profile": 0.3 * DEPTH}
    table = pd.DataFrame({"time": 3600.0, "radius": RADII / 1e3})
    table = table.assign(**{name: values[name] for name in columns})
    found = check(SCENE.changed(punch=punch), table).mistakes()
    assert found
    assert all("the difference" in each.words for each in found)
