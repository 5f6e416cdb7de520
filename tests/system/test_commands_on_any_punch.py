"""Commands on recessed, round or hollow punches: files, refusals and exit status."""

import meshio
import numpy as np
import pandas
import pytest
from natural import natural
from rough_faces import rough

from ringwear import Scene, main, run

RECESSED = natural(
    {
        "radius": 2.0,
        "ring_edges": [0.8, 1.4, 2.0],
        "wear_coefficients": [1, 10],
        "recess": [0.0, 0.01, 0.0],
    },
    [0.0, 0.1],
    1e-2,
    "fem",
    half_space={"plane_strain_modulus": 5.0},
    load={"normal_force": 0.3},
)
SPHERE = Scene.load("sphere").changed(methods=["mdr"])
HOLLOW = natural(
    {"inner_radius": 0.4, "rings": 2, "wear_coefficients": [1.0, 3.0]},
    [0.0, 0.01, 0.1, 1.0],
    methods="mdr",
)


def write_scene(scene, folder):
    path = folder / "scene.toml"
    path.write_text(scene.to_toml(), "utf-8")
    return str(path)


@pytest.mark.slow
def test_files_of_a_recessed_punch(tmp_path):
    out = tmp_path / "out"
    assert main(["run", write_scene(RECESSED, tmp_path), "--out", str(out), "--csv"]) in (0, 3)
    files = {file.name for file in out.iterdir()}
    assert {"contact.png", "history.png", "results.nc", "solver_time_edge.csv"} <= files
    assert {"half_space.vtu", "stress.png", "mesh.png"} <= files
    page = (out / "report.html").read_text("utf-8")
    assert "of the unworn face at the start" in page
    # one anchor has these words in its name
    assert "flat punch</td>" not in page.replace("reciprocity with the flat punch</td>", "")


def test_field_times_without_a_history_are_refused_before_anything_is_computed(tmp_path, capsys):
    scene = SPHERE.changed(output__field_times=[0.1], output__quantities=["steady"])
    path = write_scene(scene, tmp_path)
    assert main(["run", path, "--out", str(tmp_path / "out")]) == 2
    # the stages of a method would be lines on standard error, too
    (line,) = capsys.readouterr().err.splitlines()
    assert "output.field_times" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_face_too_rough_for_the_cells_ends_with_status_3(tmp_path):
    scene = rough(200, normal_force=1e-2)
    command = ["run", write_scene(scene, tmp_path), "--no-figures"]
    assert main([*command, "--out", str(tmp_path / "out")]) == 3


@pytest.mark.slow
def test_files_of_a_washer_and_its_free_surface(tmp_path):
    assert main(["run", "washer", "--rtol", "1e-2", "--out", str(tmp_path / "run")]) == 0
    files = {file.name for file in (tmp_path / "run").iterdir()}
    assert {"profiles_and_pressures.png", "stress.png", "half_space.vtu", "mesh.png"} <= files
    # there is no pressure on the surface under the hole
    inside = meshio.read(tmp_path / "run" / "half_space.vtu")
    radius, height, _ = inside.points.T
    surface = (height == 0) & (radius < 0.9 * 0.012)
    steady = inside.point_data["stress_zz steady"]
    assert surface.sum() > 5
    assert np.abs(steady[surface]).max() <= 1e-2 * np.abs(steady).max()


@pytest.mark.slow
def test_rows_of_a_checked_file_within_a_hole_are_left_out(tmp_path):
    table = run(HOLLOW).dataset.isel(solver=0)[["pressure"]].to_dataframe().reset_index()
    within = table.assign(radius=0.1, pressure=0.0).drop_duplicates("time")
    pandas.concat([table, within])[["time", "radius", "pressure"]].to_csv(
        tmp_path / "theirs.csv", index=False
    )
    (tmp_path / "scene.toml").write_text(HOLLOW.to_toml(), "utf-8")
    command = ["check", str(tmp_path / "scene.toml"), str(tmp_path / "theirs.csv")]
    assert main([*command, "--out", str(tmp_path / "check")]) == 0
