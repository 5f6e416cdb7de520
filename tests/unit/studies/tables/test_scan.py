"""Scans of a punch: lines along a radius or a diameter, and maps, as other programs write them."""

import numpy as np
import pytest

from ringwear import Scene, SceneError
from ringwear.studies.tables.scan import read_scan

R = np.linspace(0, 1, 51)
PARABOLA = R**2 / 18


def written(path, columns, separator=",", head="", form="{:.10f}"):
    rows = (separator.join(form.format(value) for value in row) for row in np.transpose(columns))
    path.write_text("\n".join([*([head] * bool(head)), *rows, ""]), "utf-8")
    return path


def decimal_commas(path):
    path.write_text(path.read_text("utf-8").replace(".", ","), "utf-8")
    return path


def test_separators_headings_and_decimals(tmp_path):
    path = tmp_path / "scan.txt"
    files = [
        lambda: written(path, (R, PARABOLA), head="radius,height"),
        lambda: written(path, (R, PARABOLA), "\t"),
        lambda: written(path, (R, PARABOLA), "  "),
        lambda: decimal_commas(written(path, (R, PARABOLA), ";", "x;z")),
        lambda: decimal_commas(written(path, (R, PARABOLA), " ")),
        lambda: written(path, (PARABOLA, R), head="height,radius"),
        lambda: written(path, (R, PARABOLA), " ", "# r z"),
        lambda: written(path, (R, 0 * R, R, PARABOLA), head="id,quality,lateral,topography"),
        lambda: written(path, (R, PARABOLA), ";", "Instrument;X;1\nDate;today;2\nr;z"),
        lambda: written(path, (R, PARABOLA), "  ", "profile of a punch\nmeasured twice"),
    ]
    for write in files:
        scan = read_scan(write())
        np.testing.assert_allclose(scan.radii, R, atol=1e-9)
        np.testing.assert_allclose(scan.heights, PARABOLA, atol=1e-9)
        assert not scan.notes


def test_units_are_in_headings_or_below_them(tmp_path):
    micrometres = 1e3 * PARABOLA
    for head in ("x [mm],z [µm]", "Lateral,Height\nmm,um"):
        path = written(tmp_path / "scan.csv", (R, micrometres), head=head)
        table = Scene.load("sphere").table() | {"units": "mm, N, MPa, s"}
        table["punch"] = {"radius": 1.0, "wear_coefficient": 1e-9}
        table["punch"]["profile"] = {"kind": "table", "file": str(path)}
        profile = Scene.from_table(table).punch.profile
        np.testing.assert_allclose(profile.heights, PARABOLA, atol=1e-9)
        assert profile.radii[-1] == 1.0


def test_values_that_are_no_numbers_are_left_out_and_counted(tmp_path):
    path = written(tmp_path / "scan.csv", (R, PARABOLA), head="radius,height")
    lines = path.read_text("utf-8").splitlines()
    for row, value in ((5, "Bad"), (20, "nan"), (30, "")):
        lines[row] = f"{lines[row].partition(',')[0]},{value}"
    path.write_text("\n".join(lines), "utf-8")
    scan = read_scan(path)
    assert len(scan.radii) == 48
    assert scan.notes == ("3 of 51 values left out: no numbers",)
    np.testing.assert_allclose(scan.heights, scan.radii**2 / 18, atol=1e-9)


@pytest.mark.parametrize("count", [101, 100])
def test_a_scan_over_the_diameter_is_folded(tmp_path, count):
    x = np.linspace(-1, 1, count)
    lopsided = x**2 / 18 + np.where(x > 0, 1e-3, -1e-3) * x**2
    scan = read_scan(written(tmp_path / "scan.csv", (x, lopsided), head="x,z"))
    np.testing.assert_allclose(scan.heights, scan.radii**2 / 18, atol=1e-9)
    assert scan.radii[[0, -1]].tolist() == [0.0, 1.0]
    assert "halves differ by up to 0.002" in scan.notes[0]
    # the axis is found where the scan does not begin at it
    moved = written(tmp_path / "moved.csv", (x + 3.0, x**2 / 18), head="x,z")
    scan = read_scan(moved, center=True)
    np.testing.assert_allclose(scan.heights, scan.radii**2 / 18, atol=1e-8)
    assert "the axis is at the position 3" in scan.notes[0]


@pytest.mark.parametrize("x", [R, np.linspace(-1, 1, 81)], ids=["radius", "diameter"])
def test_offset_and_tilt_are_removed_only_on_request(tmp_path, x):
    tilted = x**2 / 18 - 0.3 - 0.02 * x
    path = written(tmp_path / "scan.csv", (x, tilted), head="radius,height")
    scan = read_scan(path, level=True)
    np.testing.assert_allclose(scan.heights, scan.radii**2 / 18, atol=1e-8)
    assert any("removed" in note for note in scan.notes)
    kept = read_scan(path)
    assert kept.heights.min() == 0.0
    if x is R:
        np.testing.assert_allclose(kept.heights, tilted - tilted.min(), atol=1e-9)
        assert "was kept, because it may be real; level = true" in kept.notes[-1]


def test_a_map_is_a_mean_over_circles(tmp_path):
    x, y = np.meshgrid(*2 * [np.linspace(-1, 1, 41)])
    columns = x.ravel(), y.ravel(), (x**2 + y**2).ravel() / 18
    scan = read_scan(written(tmp_path / "map.xyz", columns, " "))
    np.testing.assert_allclose(scan.heights, scan.radii**2 / 18, atol=1e-9)
    assert scan.radii[0] == 0.0
    assert "heights differ by up to" in scan.notes[0]
    moved = columns[0] + 2.0, columns[1] - 1.0, columns[2] + 0.01 * columns[0] - 0.5
    path = written(tmp_path / "moved.xyz", moved, " ")
    scan = read_scan(path, center=True, level=True)
    np.testing.assert_allclose(scan.heights, scan.radii**2 / 18, atol=1e-8)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b,c,d\n1,2,3,4\n", "has the columns a, b, c, d: give two, radius and height"),
        ("1\n2\n", "has the columns one: give two"),
        ("r,z\n1,x\n", "line 2, column 'z': 'x'; give a number"),
        ("r,z\n1,Bad\n", "0 rows of numbers: give at least two"),
        ("x (um),y1\n0,1\n1,2\n", "units at some columns only"),
        ("# Units: um\n0,1\n1,2\n", "has a unit outside of its headings, '# Units: um'"),
        ("0,1\n1,2\n\n0,2\n1,3\n", "has each position twice or more"),
        ("x,z,x,z\n0,1,0,1\n", "two columns are called x"),
        ("", "has no rows"),
    ],
)
def test_files_that_are_no_scans_are_refused(tmp_path, text, message):
    path = tmp_path / "scan.csv"
    path.write_text(text)
    with pytest.raises(SceneError, match=message):
        read_scan(path)
    with pytest.raises(SceneError, match=r"absent.*cannot be read: no such file"):
        read_scan(tmp_path / "absent.csv")
