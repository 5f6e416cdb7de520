"""`ringwear check`: closed forms pass, and errors that are put into results are reported."""

import json
from pathlib import Path

import meshio
import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, SceneError, check, load, run

CHALLENGE = Path(__file__).parents[2] / "studies" / "challenge"
RADII = np.array([0.0, 0.13, 0.2, 0.5, 0.77, 0.98])


def flat_start(scene, radii=RADII):
    """Return the start of a flat punch in closed form, in scene units (Eqs. 10 and 11)."""
    radius, force = scene.punch.radius, scene.load_.normal_force
    pressure = force / (2 * np.pi * radius**2 * np.sqrt(1 - radii**2))
    depth = force / (2 * radius * scene.half_space.plane_strain_modulus)
    columns = {"radius": radii * radius, "pressure": pressure, "profile": 0.0, "indentation": depth}
    return pd.DataFrame({"time": 0.0, **columns, "displacement": depth, "normal_force": force})


@pytest.mark.slow
def test_closed_forms_pass(command, tmp_path):
    table = flat_start(Scene.load("five_rings"))
    # the pressure is infinite at the rim, and the second row lies outside the punch
    rim = {"time": 0.0, "radius": [1.0, 1.5], "pressure": [np.nan, 0.0], "indentation": 1.0}
    pd.concat([table, pd.DataFrame(rim)]).to_csv("fem.csv", index=False)
    shown, out = command("check five_rings fem.csv --out out"), tmp_path / "out"
    assert "fem.csv: all 5 quantities are within 0.01 of ours" in shown.out
    assert shown.out.count("fem.csv: ") - 1 == shown.out.count("no error found") == 5
    assert "1 rows beyond the punch" in shown.err
    rows = pd.read_csv(out / "check.csv")
    assert (rows.error.abs() <= rows.stated).all()
    files = {file.name for file in out.iterdir()}
    assert {"profiles_and_pressures.png", "difference.png", "report.html"} <= files
    assert json.loads((out / "summary.json").read_text("utf-8"))["errors"][0]["within"]


@pytest.mark.slow
def test_errors_are_reported_with_sign_time_and_radius(command):
    scene = Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-3)
    table = flat_start(scene)
    table["indentation"] *= 0.969
    table["pressure"] *= 1.12
    table.loc[4, "pressure"] *= 1.5 / 1.12
    table.loc[3, "displacement"] += 0.05
    table.to_csv("abaqus.csv", index=False)
    output = command("check scene.toml abaqus.csv --out out", 3, scene).out
    assert "abaqus.csv: indentation: 3.1 % too low" in output
    assert "t = 0, r = 0.77: 50 % too high" in output
    assert "displacement: too high by 5 % of the indentation" in output
    assert "r = 0.5\n" in output
    command("check scene.toml abaqus.csv --out out --within 0.5")


def test_errors_of_pressure_are_weighted_by_wear_and_area():
    """Steady pressures are w/k, so an error on one ring counts by its part of int k p^2 dA."""
    scene = Scene.load("five_rings").changed(
        methods=["mdr"], punch__rings=2, punch__width_ratio=1.5
    )
    areas, wear, radii = np.array([0.16, 0.84]), np.array([1.0, 10.0]), np.arange(0.5, 2000) / 2000
    pressure = 2 / (np.pi * np.sum(areas / wear)) / np.where(radii < 0.4, *wear)
    table = pd.DataFrame({"time": 100.0, "radius": radii, "pressure": pressure})
    table.loc[radii > 0.4, "pressure"] *= 1.5
    (row,) = check(scene, {"theirs": table}).rows
    outer = (areas / wear)[1] / np.sum(areas / wear)
    assert row.error == pytest.approx(0.5 * outer**0.5, rel=1e-3)
    assert row.there == pytest.approx(0.5, abs=1e-3)


def test_a_pressure_at_zero_force_is_an_error():
    """The scene has no force at the start, so the error has no size, and the check fails."""
    table = pd.DataFrame({"time": 0.0, "radius": [0.002, 0.004], "pressure": [1e6, 0.0]})
    checked = check(Scene.load("duty_cycle").changed(methods=["mdr"]), {"theirs": table})
    assert not checked.passes
    assert checked.summary["errors"][0]["error"] is None


def test_anchors_do_not_check_the_force_of_another_program():
    """Its error is within the limit of the check, but above the tolerance of the anchor."""
    table = flat_start(Scene.load("five_rings"))
    table["normal_force"] *= 1.002
    checked = check(Scene.load("five_rings").changed(methods=["mdr"]), {"theirs": table})
    assert "theirs" not in {anchor.method for anchor in checked.together.anchors}
    assert all(anchor.holds for anchor in checked.together.anchors)
    assert checked.passes


@pytest.mark.slow
def test_results_of_ringwear_have_errors_of_roundoff(tmp_path):
    result = run("five_rings", methods=["mdr"], rtol=1e-3)
    result.save(tmp_path / "out")
    scene = result.scene
    for given in (tmp_path / "out" / "results.nc", result.dataset):
        checked = check(scene, {"again": given}, methods=["mdr"])
        assert len(checked.rows) == 10 * len(scene.wear.times)
        assert max(abs(row.error) for row in checked.rows) < 1e-10
        assert checked.passes
    assert checked.theirs.sel(solver="again").indentation.notnull().all()
    assert checked.plot().axes


def test_columns_and_units_of_a_file_can_be_given(command):
    scene = Scene(
        units="SI",
        methods=["mdr"],
        punch={"radius": 0.01, "rings": 1, "wear_coefficients": [1e-15]},
        half_space={"plane_strain_modulus": 2e9},
        load={"normal_force": 100.0, "sliding_speed": 0.1},
    )
    table = flat_start(scene)
    table["pressure"] /= 1e6
    table[["radius", "indentation", "displacement", "profile"]] *= 1e3
    table = table.rename(columns={"pressure": "p", "radius": "r"})
    how = {"columns": {"p": "pressure", "r": "radius"}, "units": "mm, N, MPa, s"}
    checked = check(scene, {"theirs": table}, **how)
    assert len(checked.rows) == 5
    assert max(abs(row.error) - row.stated for row in checked.rows) < 1e-15
    table.to_csv("theirs.csv", index=False, sep=";")
    line = "check scene.toml theirs.csv --columns p=pressure,r=radius --out out"
    command(f"{line} --units 'mm, N, MPa, s'", scene=scene)
    command(line, 2)  # radii in mm lie beyond a punch in m


@pytest.mark.parametrize("upwards", [True, False])
def test_a_mesh_is_read_at_its_surface(upwards, tmp_path):
    """The surface has closed forms of the flat start.

    Values below the surface are zero, and there is tension beside the punch; both must not be read.
    """
    table = flat_start(Scene.load("five_rings"), np.linspace(0, 0.99, 34))
    sign = 1.0 if upwards else -1.0
    surface = np.column_stack([table["radius"], 0 * table["radius"], 0 * table["radius"]])
    points = np.concatenate([surface, surface - np.array([0, sign, 0]), [[2.0, 0.0, 0.0]]])
    nothing = np.zeros(len(table))
    down = np.concatenate([table["displacement"], nothing, [0.3]])
    stress = np.concatenate([-table["pressure"], nothing, [0.1]])
    vector = np.column_stack([0 * down, -sign * down, 0 * down])
    arrays = {"U t=0": vector, "stress_zz t=0.0": stress, "temperature": stress}
    cells = [("vertex", np.arange(len(points))[:, None])]
    file = tmp_path / "theirs.vtu"
    meshio.Mesh(points, cells, point_data=arrays).write(file)
    how = {"methods": ["mdr"], "columns": {"U t=0": "displacement t=0"}}
    checked = check("five_rings", {"theirs": file}, **how)
    assert {row.quantity for row in checked.rows} == {"displacement", "pressure"}
    assert all(abs(row.error) <= row.stated for row in checked.rows)
    with pytest.raises(SceneError, match=r"displacement t=0\.5"):
        check("five_rings", {"theirs": file}, columns={"U t=0": "U", "stress_zz t=0.0": "S"})
    file.write_text("<VTKFile>", "utf-8")
    with pytest.raises(SceneError, match="cannot be read"):
        check("five_rings", {"theirs": file})


@pytest.mark.gmsh
def test_the_half_space_of_a_run_is_read_back(command):
    """The file has two times; its surface pressures are those of the stresses inside."""
    scene = Scene.load("five_rings").changed(output__field_times=[0.1, 2.0], accuracy__rtol=1e-3)
    command("run scene.toml --no-figures --out out", scene=scene.changed(methods=["fem"]))
    checked = check(scene, {"inside": "out/half_space.vtu"}, methods=["mdr"])
    greatest = {(row.quantity, row.time): abs(row.error) for row in checked.rows}
    assert {0.1, 2.0} <= {time for _, time in greatest}
    assert max(error for (name, _), error in greatest.items() if name == "displacement") < 1e-3
    assert max(error for (name, time), error in greatest.items() if time) < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "low", "high", "looks"),
    [
        ("03_scikit_fem_080", -0.06, -0.05, "truncated half-space"),
        ("07_tamaas_256", -1e-4, 1e-4, ""),
        ("01_contact_mechanics_256", -1e-2, 1e-2, ""),
    ],
)
def test_results_of_the_wear_challenge(program, low, high, looks):
    """A clamped boundary of scikit-fem is diagnosed; two programs on grids pass."""
    (problem,) = CHALLENGE.glob(f"{program[:2]}*.toml")
    table = pd.read_csv(CHALLENGE / "others" / f"{program}.csv", comment="#")
    given = table.query("radius < 0.95")
    checked = check(problem, {program: given}, methods=["mdr"])
    start = next(row.error for row in checked.rows if row.quantity == "indentation")
    assert low <= start <= high
    assert {fault.name for fault in checked.mistakes(program)} == {looks} - {""}


@pytest.mark.parametrize(
    ("sizes", "order", "off", "honest"),
    [
        ((0.2, 0.1, 0.05), 2.0, 0.0, True),
        ((0.3, 0.2, 0.07), 1.5, 0.0, True),  # ratios of sizes differ
        ((0.2, 0.1, 0.05), 2.0, -0.03, False),  # they converge to a wrong value
    ],
)
def test_a_refinement_of_known_order(sizes, order, off, honest):
    """For v (1 + off + h^p), Richardson's limit is v (1 + off), the index 1.25 h^p v."""
    scene = Scene.load("flat_punch").changed(methods=["mdr"])
    files = {
        f"h = {size}": flat_start(scene)[["time", "indentation"]].mul([1, 1 + off + size**order])
        for size in sizes
    }
    checked = check(scene, files, sizes=sizes)
    (row,) = checked.refinements
    limit, index = row.estimate
    finest = sizes[-1] ** order
    assert limit == pytest.approx(off, abs=1e-6)
    assert index == pytest.approx(1.25 * finest / (1 + off + finest), rel=1e-4)
    assert (index >= row.errors[-1]) == honest
    if honest:
        np.testing.assert_allclose(row.orders, order, rtol=1e-4)
    assert ("TOO SMALL" in checked.texts.lines[-1]) != honest
    assert checked.passes == (abs(off + finest) <= 0.01)


@pytest.mark.slow
def test_a_refinement_that_stalls(command, tmp_path):
    for size in (0.2, 0.1, 0.05, 0.025):
        table = flat_start(Scene.load("flat_punch"))
        table["pressure"] *= 1 + np.hypot(size**2, 0.002)
        table.to_csv(f"{size}.csv", index=False)
    line = "check flat_punch 0.2.csv 0.1.csv 0.05.csv 0.025.csv --out out --sizes"
    output = command(f"{line} 0.2,0.1,0.05,0.025").out
    assert "pressure at t = 0: order" in output
    assert "stalls from size 0.05 on" in output
    assert (tmp_path / "out" / "refinement.png").exists()
    command(f"{line} 0.1,0.2,0.3,0.4", 2)


MALFORMED = [
    ("", "has no rows: give names of columns"),
    ("time,radius,pressure\n", "has no rows: give names of columns"),
    ("0,0.5,1\n0,0.6,1\n", "line 1: the first line must name the columns"),
    ("radius,pressure\n0.5,1\n", "no column 'time'"),
    ("time,pressure\n0,1\n", "no column 'radius'"),
    ("time,radius,presure\n0,0.5,1\n", "no column 'pressure'"),
    ("time,time,indentation\n0,0,1\n", "two columns are called time"),
    ("time,radius,pressure\n0,0.5,high\n", "line 2, column 'pressure': 'high'; give a number"),
    ("# of others\ntime;radius;pressure\n0;0;5;1\n", "line 3: 4 cells under 3 columns"),
    ("time,radius,pressure\n0,0.5,1\n\n0,0.6\n", "line 4: 2 cells under 3 columns"),
    ("time,radius,pressure\n0,0.5,1\n,0.6,1\n", "line 3, column 'time'"),
    ("time,radius,pressure\n0,0.5,1\n0,,1\n", "line 3, column 'radius'"),
    ("time,radius,pressure\n-1,0.5,1\n", "line 2, column 'time': '-1'; give the time since"),
    ("time,radius,pressure\n0,-0.5,1\n", "line 2, column 'radius': '-0.5'; give the distance"),
    ("time,radius,pressure\n0,0.5,1\n0,0.50,2\n", "line 3, column 'radius': '0.50'; give each"),
    ("time,radius,pressure\n0,0.5,inf\n", "line 2, column 'pressure': 'inf'; leave it empty"),
    ("time,indentation\n0,1\n0,2\n", "line 2, column 'indentation': '1'; give one number"),
    ("time,radius,pressure\n0,500,1\n", "beyond punch.radius = 1"),
    ("time,radius,pressure\n0,0.5,\n", "no number"),
    (b"\xff\xfe\x80\x00", "cannot be read"),
    (None, "no such file"),
]


@pytest.mark.parametrize(("content", "words"), MALFORMED)
def test_a_malformed_file_is_refused(content, words, command, tmp_path):
    """The status is 2, one line names the file and what to do, and nothing is written."""
    file = tmp_path / "theirs.csv"
    if content is not None:
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
    (line,) = command(f"check five_rings {file} --out out", 2).err.splitlines()
    assert str(file) in line
    assert words in line
    assert "give" in line or "leave" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("", "give their files"),
        ("a.csv --columns q=pressure", "no column 'q'"),
        ("a.csv --columns pressure", "theirs=ours"),
        ("a.csv --units 'mm, N, MPa, s'", "the scene's numbers have none"),
        ("a.nc", "cannot be read"),
        ("a.csv --sizes 0.1", "two or more"),
        ("a.csv b.csv --sizes 0.1,0.2", "decreasing"),
    ],
)
def test_a_malformed_option_is_refused(flags, words, command, tmp_path):
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("time,radius,pressure\n0,0.5,1\n", "utf-8")
    assert words in command(f"check five_rings {flags}", 2).err


def test_another_program_may_not_have_the_name_of_a_method():
    with pytest.raises(SceneError, match="another name"):
        check("five_rings", {"mdr": pd.DataFrame({"time": [0.0], "indentation": [1.0]})})


def test_errors_are_saved_before_mistakes_are_tried(tmp_path, monkeypatch):
    """Mistakes take seconds: what was computed before stays if they are stopped."""
    scene = Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-3)
    checked = check(scene, {"abaqus": flat_start(scene).assign(indentation=1.05)})

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("ringwear.studies.check.check.diagnose", stop)
    with pytest.raises(KeyboardInterrupt, match="what was complete is in place"):
        checked.save(tmp_path / "out")
    assert {file.name for file in (tmp_path / "out").iterdir()} == {
        *(".ringwear.json", "check.csv", "results.nc", "summary.json")
    }
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert not summary["check"]["passes"]
    assert "mistakes" not in summary
    errors_of = {row["quantity"]: row["error"] for row in summary["errors"]}
    assert errors_of["indentation"] == pytest.approx(0.05, rel=1e-2)
    assert load(tmp_path / "out").of_others == ("abaqus",)
