"""Columns of other programs: their names, signs and units, grids, and times that files lack."""

import numpy as np
import pandas as pd
import pytest
from flat_export import PRESSURE, SCENE, R

from ringwear import SceneError
from ringwear.studies.check.tables import read
from ringwear.studies.tables.headings import name_of


@pytest.mark.parametrize(
    ("heading", "name"),
    [
        *dict.fromkeys(
            ("CPRESS", "CPRESS-path", "CONTPRES", "contact_pressure"), "pressure"
        ).items(),
        *dict.fromkeys(
            ("solid.Tn (N/m^2)", "Contact Pressure", "S-S22", "sigma_zz"), "pressure"
        ).items(),
        *dict.fromkeys(("S, S22", "stress_yy [MPa]", "solid.sz"), "pressure").items(),
        *dict.fromkeys(
            ("U2", "U-U2", "uy", "disp_y", "disp:1", "Displacement Y"), "displacement"
        ).items(),
        *dict.fromkeys(("x", "Points:0", "arc_length", "COORD_X", "r-coord"), "radius").items(),
        *dict.fromkeys(("X Location (m)", "lateral"), "radius").items(),
        *dict.fromkeys(("Directional Deformation (mm)", "Y displacement"), "displacement").items(),
        *dict.fromkeys(("RF2", "RF-RF2", "CFN2"), "normal_force").items(),
        ("Total Time", "time"),
        ("vtkValidPointMask", None),
        ("temperature", None),
    ],
)
def test_columns_of_other_programs_are_known(heading, name):
    found = name_of(heading)
    assert (found[1].name if found else None) == name


def same(table, time=0.0):
    """Assert that a table has the pressures and displacements of the flat punch."""
    np.testing.assert_allclose(table["radius"], R)
    np.testing.assert_allclose(table["pressure"], PRESSURE, rtol=1e-9)
    if "displacement" in table:
        np.testing.assert_allclose(table["displacement"], 1.0, rtol=1e-9)
    assert (table["time"] == time).all()


@pytest.mark.parametrize(
    "columns",
    [
        {"x": R, "CPRESS": PRESSURE, "U2": -1.0},
        {"Points:0": R, "arc_length": R, "sigma_zz": -PRESSURE, "disp:1": -1.0, "disp:2": 0.0},
        {"r [um]": 1e3 * R, "solid.Tn [Pa]": 1e6 * PRESSURE, "w [m]": 1e-3},
        {"Points:0": R, "contact_pressure": PRESSURE, "disp:0": 0.1, "Points:1": 0.0},
    ],
)
def test_signs_units_and_places_are_read(columns):
    same(read(pd.DataFrame(columns), "theirs", SCENE, {}, "", time=0.0))


def test_two_columns_that_may_be_one_quantity_are_asked_about():
    table = pd.DataFrame({"r": R, "disp_y": 1.0, "disp_z": 0.5})
    with pytest.raises(SceneError, match="'disp_y' and 'disp_z' may both be displacement: choose"):
        read(table, "theirs", SCENE, {}, "", time=0.0)
    chosen = read(table, "theirs", SCENE, {"disp_z": "displacement"}, "", time=0.0)
    assert (chosen["displacement"] == 0.5).all()


def test_radii_that_may_be_in_another_unit_are_asked_about():
    table = pd.DataFrame({"r": [0.5, 1000.0], "pressure": 1.0})
    with pytest.raises(SceneError, match=r"radii reach 1000 times punch.radius = 1 .*a unit\)"):
        read(table, "theirs", SCENE, {}, "", time=0.0)
    stated = read(table.rename(columns={"r": "r [um]"}), "theirs", SCENE, {}, "", time=0.0)
    assert stated["radius"].tolist() == [0.0005, 1.0]


def test_a_history_of_the_punch_has_a_force_and_an_approach():
    times = np.array([0.0, 1.0])
    table = pd.DataFrame({"X": times, "RF2-history": -2.0, "U2-history": [-1.0, -1.5]})
    found = read(table, "theirs", SCENE, {}, "")
    assert found["time"].tolist() == times.tolist()
    assert found["normal_force"].tolist() == [2.0, 2.0]
    assert found["indentation"].tolist() == [1.0, 1.5]


def test_a_grid_is_a_mean_over_circles(caplog):
    x, y = (each.ravel() for each in np.meshgrid(*2 * [np.linspace(-0.6, 0.6, 13)]))
    pressure = 1 / (np.pi * np.sqrt(1 - x**2 - y**2))
    grid = pd.DataFrame({"x": x, "y": y, "pressure": pressure})
    with caplog.at_level("INFO"):
        table = read(grid, "theirs", SCENE, {}, "", time=0.0)
    np.testing.assert_allclose(table["pressure"], 1 / (np.pi * np.sqrt(1 - table["radius"] ** 2)))
    assert table["radius"].is_monotonic_increasing
    assert "means over circles around the axis, on which values differ by up to" in caplog.text


def test_a_line_through_the_axis_is_a_mean_over_both_sides():
    both = np.concatenate([-R[:0:-1], R])
    table = pd.DataFrame({"x": both, "CPRESS": 1 / (np.pi * np.sqrt(1 - both**2)), "uy": -1.0})
    same(read(table, "theirs", SCENE, {}, "", time=0.0))


def test_headings_in_comments_and_reports_of_columns(tmp_path):
    rows = "".join(f"{r:.6f}  {p:.9f}\n" for r, p in zip(R, PRESSURE, strict=True))
    heads = [
        "% Model:  punch.mph\n% r                       solid.Tn (N/m^2)\n",
        "% Length unit: mm\n% x    Contact pressure (MPa)\n",
        "# r p\n",
        "Project;punch\nOperator;A\nr;p\n",
        "\n\n            X            CPRESS-path   \n\n",
    ]
    for number, head in enumerate(heads):
        path = tmp_path / ("path.rpt" if "CPRESS" in head else f"{number}.txt")
        path.write_text(head + (rows.replace("  ", ";") if ";" in head else rows))
        table = read(path, path.name, SCENE, {}, "", time=0.0)
        np.testing.assert_allclose(table["pressure"], PRESSURE, rtol=1e-6)
