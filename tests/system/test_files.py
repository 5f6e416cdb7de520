"""The command line from end to end: files, their contents, exit status, and nothing half-
written.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import xarray
from conftest import WITHOUT_GMSH

from ringwear import Scene, run
from ringwear.studies.cli import main
from ringwear.studies.methods.quantities import A_FEW

VARIABLES = {
    "pressure": ("solver", "time", "radius"),
    "profile": ("solver", "time", "radius"),
    "displacement": ("solver", "time", "radius"),
    "indentation": ("solver", "time"),
    "displacement_centre": ("solver", "time"),
    "displacement_max": ("solver", "time"),
    "rms_slope": ("solver", "time"),
    "ring_force": ("solver", "time", "ring"),
    "relaxation_time": ("solver", "mode"),
    "steady_pressure": ("solver", "radius"),
    "steady_profile": ("solver", "radius"),
    "steady_displacement_max": ("solver",),
    "steady_rms_slope": ("solver",),
    "steady_wear_rate": ("solver",),
}
# errors are norms over the radius and the rings
VARIABLES |= {
    f"{name}_error": tuple(dim for dim in dims if dim not in ("radius", "ring"))
    for name, dims in VARIABLES.items()
}
OF_PUNCH = (
    "indentation_start",
    "indentation_steady",
    "running_in_time",
    "time_to_90",
    "time_to_99",
)
ANSWER = dict.fromkeys(OF_PUNCH, ("solver",))
ANSWER |= dict.fromkeys(
    ("pressure_min", "pressure_max", "force_share"), ("solver", "state", "ring")
)
ANSWER |= {"worn_volume": ("solver", "ring")}
FILES = {"results.nc", "summary.json", "half_space.vtu"}


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The main job, with lengths and forces that are not one."""
    directory = tmp_path_factory.mktemp("run")
    scene = Scene.load("five_rings").changed(
        units="mm, N, MPa, s",
        punch__radius=2.0,
        half_space__plane_strain_modulus=3.0,
        load__normal_force=5.0,
    )
    (directory / "scene.toml").write_text(scene.to_toml(), "utf-8")
    assert (
        main(
            [
                "run",
                str(directory / "scene.toml"),
                "--rtol",
                "1e-3",
                "--out",
                str(directory / "out"),
            ]
        )
        == 0
    )
    return directory / "out"


def test_results(done: Path) -> None:
    with xarray.open_dataset(done / "results.nc") as found:
        assert {name: found[name].dims for name in found.data_vars} == VARIABLES | ANSWER
        assert found.solver.values.tolist() == ["mdr", "direct", "fem"]
        sizes = dict(found.sizes)
        assert (sizes["time"], sizes["ring"]) == (len(found.time), 5)
        np.testing.assert_array_equal(found.time, Scene.load("five_rings").wear.times)
        assert Scene.from_toml(found.attrs["scene"]).accuracy.rtol == 1e-3
        assert json.loads(found.attrs["versions"])["ringwear"]
        assert found.attrs["gradient_average"] == "line"
        assert found.attrs["units"] == "mm, N, MPa, s"
        assert found.attrs["definitions"]
        for name in found.data_vars:
            assert {"units", "long_name"} <= set(found[name].attrs)


def test_results_are_in_the_scenes_units(done: Path) -> None:
    with xarray.open_dataset(done / "results.nc") as found:
        start = found.isel(time=0)
        assert float(found.radius.max()) == pytest.approx(2.0, rel=1e-3)
        np.testing.assert_allclose(start.indentation[[0, 2]], 5 / (2 * 2 * 3), rtol=1e-3)
        # p(0) = F / (2 pi a^2)
        np.testing.assert_allclose(start.pressure[[0, 2], 0], 5 / (2 * np.pi * 4), rtol=1e-2)
        np.testing.assert_allclose(found.ring_force.sum("ring")[[0, 2]], 5, rtol=1e-12)
        np.testing.assert_allclose(found.displacement, found.indentation - found.profile)
        assert found.relaxation_time.isel(mode=0)[0] == pytest.approx(
            0.3440589002 * 2 / 3, rel=1e-3
        )
        # the mean wear coefficient, times speed and mean pressure
        areas = np.diff(np.linspace(0, 1, 6) ** 2)
        mean = 1 / (areas @ (1 / np.array([1, 10, 1, 10, 1])))
        np.testing.assert_allclose(found.steady_wear_rate, mean * 5 / (4 * np.pi), rtol=1e-12)


def test_what_a_method_does_not_give_is_not_a_number(done: Path) -> None:
    with xarray.open_dataset(done / "results.nc") as found:
        direct, others = found.isel(solver=1), found.isel(solver=[0, 2])
        assert bool(np.isnan(direct.worn_volume).all())
        for name, dims in VARIABLES.items():
            history = "time" in dims or "mode" in dims
            assert bool(np.isnan(direct[name]).all()) == history
            assert not np.isnan(others[name]).any(), name
        # zero at its lowest, which may lie between two of the radii
        lowest = found.steady_profile.min("radius")
        assert ((lowest >= 0) & (lowest <= 1e-4 * found.steady_profile.max("radius"))).all()
        assert (others.indentation_error > 0).all()
        assert (np.diff(others.relaxation_time, axis=1) <= 0).all()


@pytest.mark.gmsh
def test_summary(done: Path) -> None:
    summary = json.loads((done / "summary.json").read_text("utf-8"))
    assert set(summary["methods"]) == {"mdr", "direct", "fem"}
    for method in summary["methods"].values():
        assert {"seconds", "unknowns", "rtol_asked", "error_estimate"} <= set(method)
        assert method["rtol_asked"] == 1e-3
        assert all(seconds >= 0 for seconds in method["seconds"].values())
    for row in summary["agreement"]:
        assert {
            "quantity",
            "methods",
            "difference",
            "uncertainty",
            "verdict",
            "remark",
            "promised",
            "agrees",
        } == set(row)
        assert row["agrees"] == (row["verdict"] == "agree")
        assert not row["agrees"] or row["difference"] <= row["uncertainty"] <= A_FEW * 1e-3
    pairs = {tuple(row["methods"]) for row in summary["agreement"]}
    assert pairs == {("mdr", "direct"), ("mdr", "fem"), ("direct", "fem")}
    assert summary["agrees"]
    assert summary["verdict"] == "agree"
    assert set(summary["quantities"].values()) == {"agree"}
    for row in summary["anchors"]:
        assert {"name", "method", "difference", "tolerance", "holds"} == set(row)
        assert row["holds"]
    assert len({row["name"] for row in summary["anchors"]}) >= 25
    assert summary["modelled"]
    assert all(reason for reason in summary["left_out"].values())


def test_half_space(done: Path) -> None:
    mesh = meshio.read(done / "half_space.vtu")
    assert [block.type for block in mesh.cells] == ["triangle"]
    assert mesh.points[:, 0].max() == pytest.approx(10.0 if WITHOUT_GMSH else 5.0)
    assert mesh.points[:, 1].max() == 0
    for values in mesh.point_data.values():
        assert np.isfinite(values).all()
    # downwards, all of the punch's face by the indentation
    face = (mesh.points[:, 1] == 0) & (mesh.points[:, 0] <= 2)
    np.testing.assert_allclose(
        mesh.point_data["displacement t=0"][face, 1], -5 / (2 * 2 * 3), rtol=1e-2
    )
    # on the axis: zz = -p0 (1 + 3 s^2) / (1 + s^2)^2 at depth s
    axis = (mesh.points[:, 0] == 0) & (mesh.points[:, 1] < 0) & (mesh.points[:, 1] > -6)
    depth = -mesh.points[axis, 1] / 2
    expected = -5 / (2 * np.pi * 4) * (1 + 3 * depth**2) / (1 + depth**2) ** 2
    np.testing.assert_allclose(
        mesh.point_data["stress_zz t=0"][axis], expected, atol=2e-2 * np.abs(expected).max()
    )


def test_figures(done: Path) -> None:
    figures = {file.name: file for file in done.glob("*.png")}
    assert {"profiles_and_pressures.png", "history.png", "steady_state.png", "mesh.png"} <= set(
        figures
    )
    for file in figures.values():
        assert file.read_bytes().startswith(b"\x89PNG")
    assert {file.name for file in done.iterdir()} == FILES | set(figures) | {
        ".ringwear.json",
        "report.html",
    }


@pytest.mark.parametrize(
    ("changes", "absent", "figures"),
    [
        ({"methods": ["direct"]}, {"half_space.vtu"}, {"steady_state.png"}),
        (
            {"methods": ["mdr"], "wear__steady": False},
            {"half_space.vtu"},
            {"profiles_and_pressures.png", "history.png"},
        ),
        (
            {"methods": ["mdr", "direct"], "wear__times": []},
            {"half_space.vtu"},
            {"steady_state.png"},
        ),
        (
            {"methods": ["mdr"], "wear__times": [0.0]},
            {"half_space.vtu"},
            {"profiles_and_pressures.png"},
        ),
        ({"methods": ["fem"], "wear__steady": False}, set(), {"mesh.png", "history.png"}),
        (
            {"methods": ["mdr"], "punch__wear_coefficients": [2.0, 2.0]},
            {"half_space.vtu"},
            {"history.png"},
        ),
        (
            {"methods": ["mdr", "direct"], "output__radii": [0.5]},
            {"half_space.vtu"},
            {"steady_state.png"},
        ),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_parts_of_a_scene(
    changes: dict[str, Any], absent: set[str], figures: set[str], tmp_path: Path
) -> None:
    """Every sensible part of a scene runs by itself, and writes no more than it has."""
    scene = tmp_path / "scene.toml"
    scene.write_text(
        Scene.load("five_rings").changed(accuracy__rtol=1e-3, **changes).to_toml(), "utf-8"
    )
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 0
    written = {file.name for file in (tmp_path / "out").iterdir()}
    assert written & FILES == FILES - absent
    assert figures <= written
    with xarray.open_dataset(tmp_path / "out" / "results.nc") as found:
        assert set(VARIABLES) <= set(found.data_vars)


def test_two_runs_are_the_same() -> None:
    one, other = (
        run(Scene.load("five_rings").changed(accuracy__rtol=1e-2)).dataset for _ in range(2)
    )
    assert one.identical(other)


def test_an_accuracy_that_is_not_reached_ends_in_status_3(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "scene.toml"
    text = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"],
        accuracy__rtol=1e-3,
        accuracy__fem__far_field="fixed",
        accuracy__fem__truncation=20.0,
    )
    scene.write_text(text.to_toml(), "utf-8")
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 3
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert summary["verdict"] == "undecided"
    assert not summary["agrees"]
    assert summary["methods"]["fem"]["beyond_rtol"]["indentation"] > 0.05
    (indentation,) = [row for row in summary["agreement"] if row["quantity"] == "indentation"]
    assert "far_field = 'boussinesq'" in indentation["remark"]
    # a clamped boundary takes 1.1 a/R of the indentation; the difference is relative to what is
    # left
    assert 1 / (1 + indentation["difference"]) == pytest.approx(1 - 1.1 / 20, rel=2e-3)
    assert "indentation is undecided between mdr and fem" in capsys.readouterr().out


def test_mesh_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mesh", "rubber", "--out", str(tmp_path / "out")]) == 0
    assert {file.name for file in (tmp_path / "out").iterdir()} == {
        "mesh.vtu",
        "mesh.png",
        ".ringwear.json",
    }
    mesh = meshio.read(tmp_path / "out" / "mesh.vtu")
    assert mesh.points[:, 0].max() == pytest.approx((5 if WITHOUT_GMSH else 2.5) * 0.005)
    assert ("triangles" if WITHOUT_GMSH else "quadrilaterals") in capsys.readouterr().out


def test_plan_and_scenes_write_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["plan", "rubber"]) == 0
    assert main(["scenes"]) == 0
    assert list(tmp_path.iterdir()) == []
