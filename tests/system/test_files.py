"""The command line from end to end: files, their contents, exit status, no half-written files."""

import json
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
import xarray
from conftest import WITHOUT_GMSH
from skfem import MeshQuad

from ringwear import Scene, load, run
from ringwear.meshes.files import read

# names of all variables, by their dimensions
VARIABLES = {
    ("time", "radius"): ("pressure", "profile", "displacement"),
    ("time",): (
        *("indentation", "displacement_centre", "displacement_max", "rms_slope", "normal_force"),
        *("contact_radius", "mean_contact_radius"),
    ),
    ("time", "ring"): ("ring_force", "ring_worn_volume"),
    ("mode",): ("relaxation_time",),
    ("radius",): ("steady_pressure", "steady_profile"),
    (): ("steady_displacement_max", "steady_rms_slope", "steady_wear_rate"),
}
ANSWER = {
    (): (
        *("indentation_start", "indentation_steady", "force_start", "force_end"),
        *("running_in_time", "time_to_90", "time_to_99", "time_to_half_force"),
        *("contact_radius_start", "contact_radius_end", "time_to_full_contact"),
        *("worn_depth_end", "pressure_peak_start"),
    ),
    ("state", "ring"): ("pressure_min", "pressure_max", "force_share"),
    ("ring",): ("worn_volume",),
}


def with_errors(variables, norms_over):
    """Return the dimensions of variables and of their errors, which are norms over some."""
    dims = {name: of for of, names in variables.items() for name in names}
    return dims | {
        f"{name}_error": tuple(dim for dim in of if dim not in norms_over)
        for name, of in dims.items()
    }


VARIABLES = with_errors(VARIABLES, ("radius", "ring")) | {
    "contact": ("time", "radius"),
    "contact_edge": ("time", "edge"),
}
ANSWER = with_errors(ANSWER, ("ring",))
NUMBERS = {"results.nc", "summary.json"}
PAGE = {"report.html", ".ringwear.json"}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Run the main job with a radius, a force and a modulus that are not one."""
    scene = Scene.load("five_rings").changed(
        units="mm, N, MPa, s",
        punch__radius=2.0,
        half_space__plane_strain_modulus=3.0,
        load__normal_force=5.0,
    )
    out = tmp_path_factory.mktemp("run")
    run(scene.changed(accuracy__rtol=1e-3)).save(out)
    return out


@pytest.fixture(scope="module")
def results(done):
    return xarray.load_dataset(done / "results.nc")


@pytest.mark.slow
def test_results_nc_has_all_quantities(results):
    dims = {name: ("solver", *dims) for name, dims in (VARIABLES | ANSWER).items()}
    assert {name: results[name].dims for name in results} == dims
    assert results.solver.values.tolist() == ["mdr", "direct", "fem"]
    assert results.sizes["ring"] == 5
    np.testing.assert_array_equal(results.time, Scene.load("five_rings").wear.times)
    assert Scene.from_toml(results.attrs["scene"]).accuracy.rtol == 1e-3
    assert json.loads(results.attrs["versions"])["ringwear"]
    assert {"gradient_average": "line", "units": "mm, N, MPa, s"}.items() <= results.attrs.items()
    assert results.attrs["definitions"]
    assert all({"units", "long_name"} <= set(results[name].attrs) for name in results)


def test_results_are_in_the_scenes_units(results):
    start = results.isel(time=0, solver=[0, 2])
    assert float(results.radius.max()) == pytest.approx(2.0, rel=1e-3)
    np.testing.assert_allclose(start.indentation, 5 / (2 * 2 * 3), rtol=1e-3)
    # p(0) = F / (2 pi a^2)
    np.testing.assert_allclose(start.pressure[:, 0], 5 / (2 * np.pi * 4), rtol=1e-2)
    np.testing.assert_allclose(results.displacement, results.indentation - results.profile)
    assert results.relaxation_time[0, 0] == pytest.approx(0.3440589002 * 2 / 3, rel=1e-3)
    # the mean wear coefficient, times speed and mean pressure
    areas = np.diff(np.linspace(0, 1, 6) ** 2)
    mean = 1 / (areas @ (1 / np.array([1, 10, 1, 10, 1])))
    np.testing.assert_allclose(results.steady_wear_rate, mean * 5 / (4 * np.pi), rtol=1e-12)


def test_values_that_a_method_does_not_compute_are_nan(results):
    direct, others = results.isel(solver=1), results.isel(solver=[0, 2])
    assert np.isnan(direct.worn_volume).all()
    for name, dims in VARIABLES.items():
        assert bool(np.isnan(direct[name]).all()) == ("time" in dims or "mode" in dims)
        values = others[name]
        if name == "relaxation_time":
            # faster ones are reported as far as they are resolved
            values = values.isel(mode=slice(8))
        assert not np.isnan(values).any(), name
    # zero at the lowest point, which may lie between two radii
    lowest = results.steady_profile.min("radius")
    assert ((lowest >= 0) & (lowest <= 1e-4 * results.steady_profile.max("radius"))).all()
    assert (others.indentation_error > 0).all()
    assert (np.diff(others.relaxation_time.isel(mode=slice(8)), axis=1) <= 0).all()


@pytest.mark.gmsh
def test_the_summary_of_a_run(done):
    summary = load(done).summary
    assert set(summary["methods"]) == {"mdr", "direct", "fem"}
    for method in summary["methods"].values():
        assert {"seconds", "unknowns", "rtol_asked", "error_estimate"} <= set(method)
        assert method["rtol_asked"] == 1e-3
    keys = "quantity methods difference uncertainty verdict remark when promised agrees"
    for row in summary["agreement"]:
        assert set(keys.split()) == set(row)
        assert row["agrees"]
        assert row["difference"] <= row["uncertainty"] <= 2 * 1e-3
    pairs = {tuple(row["methods"]) for row in summary["agreement"]}
    assert pairs == {("mdr", "direct"), ("mdr", "fem"), ("direct", "fem")}
    assert {summary["verdict"], *summary["quantities"].values()} == {"agree"}
    for row in summary["anchors"]:
        assert {"name", "method", "difference", "tolerance", "holds"} == set(row)
        assert row["holds"]
    assert summary["modelled"]
    assert all(summary["left_out"].values())


def test_the_file_of_the_half_space(done):
    mesh = meshio.read(done / "half_space.vtu")
    r, y, _ = mesh.points.T
    assert [block.type for block in mesh.cells] == ["triangle"]
    assert r.max() == pytest.approx(10.0 if WITHOUT_GMSH else 5.0)
    assert y.max() == 0
    assert all(np.isfinite(values).all() for values in mesh.point_data.values())
    # the whole face moves down by the indentation
    moved = mesh.point_data["displacement t=0"][(y == 0) & (r <= 2), 1]
    np.testing.assert_allclose(moved, -5 / (2 * 2 * 3), rtol=1e-2)
    # on the axis: zz = -p0 (1 + 3 s^2) / (1 + s^2)^2 at depth s
    axis = (r == 0) & (y < 0) & (y > -6)
    depth = -y[axis] / 2
    expected = -5 / (2 * np.pi * 4) * (1 + 3 * depth**2) / (1 + depth**2) ** 2
    stress = mesh.point_data["stress_zz t=0"][axis]
    np.testing.assert_allclose(stress, expected, atol=2e-2 * np.abs(expected).max())


STATES = {"profiles_and_pressures.png"}
HISTORY = STATES | {"history.png"}
STEADY = {"steady_state.png"}
DIFFERENCE = {"difference.png"}
INSIDE = {"half_space.vtu", "stress.png", "mesh.png"}


def test_a_run_writes_all_its_files(done):
    files = {file.name for file in done.iterdir()}
    drawn = HISTORY | STEADY | INSIDE | DIFFERENCE
    assert files == NUMBERS | PAGE | drawn
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in done.glob("*.png"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "figures"),
    [
        ({"methods": ["direct"]}, STEADY),
        ({"methods": ["mdr"], "wear__steady": False}, HISTORY),
        ({"methods": ["mdr", "direct"], "wear__times": []}, STEADY | DIFFERENCE),
        ({"methods": ["mdr"], "wear__times": [0.0]}, STATES | STEADY),
        ({"methods": ["fem"], "wear__steady": False}, HISTORY | INSIDE),
        ({"methods": ["mdr"], "punch__wear_coefficients": [2.0, 2.0]}, HISTORY | STEADY),
        ({"methods": ["mdr", "direct"], "output__radii": [0.5]}, HISTORY | STEADY | DIFFERENCE),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_parts_of_a_scene(changes, figures, command, tmp_path):
    """Every sensible part of a scene runs by itself, and writes only the files for that part."""
    scene = Scene.load("five_rings").changed(accuracy__rtol=1e-2, **changes)
    command("run scene.toml --out out", scene=scene)
    assert {file.name for file in (tmp_path / "out").iterdir()} == NUMBERS | PAGE | figures
    assert set(VARIABLES) <= set(xarray.load_dataset("out/results.nc"))


def test_two_runs_are_the_same():
    scene = Scene.load("five_rings").changed(accuracy__rtol=1e-2)
    assert run(scene).dataset.identical(run(scene).dataset)


@pytest.mark.slow
def test_an_accuracy_that_is_not_reached_ends_with_status_3(command):
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"],
        accuracy__rtol=1e-3,
        accuracy__fem__far_field="fixed",
        accuracy__fem__truncation=20.0,
    )
    lines = command("run scene.toml --no-figures --out out", 3, scene).out.splitlines()
    summary = load("out").summary
    assert summary["verdict"] == "undecided"
    assert not summary["agrees"]
    assert summary["methods"]["fem"]["beyond_rtol"]["indentation"] > 0.05
    (indentation,) = [row for row in summary["agreement"] if row["quantity"] == "indentation"]
    assert "far_field = 'boussinesq'" in indentation["remark"]
    # a clamped boundary takes 1.1 a/R of the indentation; the difference is relative to the whole
    assert 1 - indentation["difference"] == pytest.approx(1 - 1.1 / 20, rel=2e-3)
    assert any("undecided: " in line and "indentation" in line for line in lines)


@pytest.mark.slow
def test_the_inside_is_written_as_a_series(command, tmp_path):
    """ParaView opens one file for each time, with the same numbers as the file of all times."""
    scene = Scene.load("flat_punch").changed(
        methods=["fem"], accuracy__rtol=1e-2, output__field_times=[0.0, 0.3]
    )
    command("run scene.toml --no-figures --out out", scene=scene)
    out = tmp_path / "out"
    sets = ElementTree.parse(out / "half_space.pvd").findall(".//DataSet")
    assert [float(each.get("timestep")) for each in sets] == [0.0, 0.3]
    whole = meshio.read(out / "half_space.vtu").point_data
    for each in sets:
        data = meshio.read(out / each.get("file")).point_data
        for name, values in data.items():
            np.testing.assert_array_equal(
                values, whole[f"{name} t={float(each.get('timestep')):g}"]
            )


@pytest.mark.gmsh
def test_the_mesh_that_the_command_writes_is_read_back(command, tmp_path):
    scene = Scene.load("rubber")
    assert "quadrilaterals" in command("mesh rubber --out .").out
    assert {file.name for file in tmp_path.glob("[!.]*")} == {"mesh.vtu", "mesh.png"}
    assert meshio.read(tmp_path / "mesh.vtu").points[:, 0].max() == pytest.approx(2.5 * 0.005)
    mesh = read(tmp_path / "mesh.vtu", scene.problem.merged.ring_edges, scene.punch.radius)
    written = MeshQuad.load(tmp_path / "mesh.vtu")
    assert set(mesh.boundaries) == set(written.boundaries)
    assert mesh.nelements == written.nelements
    # subdomains mark layers in which the degree may be lower
    lower, written_lower = (
        {name: len(part) for name, part in each.subdomains.items()} for each in (mesh, written)
    )
    assert lower == written_lower
