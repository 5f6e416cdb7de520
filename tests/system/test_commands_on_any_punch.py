"""Commands on recessed, round or hollow punches: files, refusals and exit status."""

import meshio
import numpy as np
import pandas
import pytest
from natural import natural
from rough_faces import rough

from ringwear import Scene, run

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


@pytest.mark.slow
def test_files_of_a_recessed_punch(command, tmp_path):
    command("run scene.toml --out out --csv", scene=RECESSED)
    out = tmp_path / "out"
    files = {file.name for file in out.iterdir()}
    assert {"contact.png", "history.png", "results.nc", "solver_time_edge.csv"} <= files
    assert {"half_space.vtu", "stress.png", "mesh.png"} <= files
    page = (out / "report.html").read_text("utf-8")
    assert "of the unworn face at the start" in page
    # one anchor has these words in its name
    assert "flat punch</td>" not in page.replace("reciprocity with the flat punch</td>", "")


def test_field_times_without_a_history_are_refused_before_anything_is_computed(command, tmp_path):
    scene = SPHERE.changed(output__field_times=[0.1], output__quantities=["steady"])
    printed = command("run scene.toml --out out", 2, scene)
    # the stages of a method would be lines on standard error, too
    (line,) = printed.err.splitlines()
    assert "output.field_times" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_face_too_rough_for_the_cells_ends_with_status_3(command):
    command("run scene.toml --no-figures --out out", 3, rough(200, normal_force=1e-2))


@pytest.mark.slow
def test_files_of_a_washer_and_its_free_surface(command, tmp_path):
    command("run washer --rtol 1e-2 --out run")
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
def test_rows_of_a_checked_file_within_a_hole_are_left_out(command):
    table = run(HOLLOW).dataset.isel(solver=0)[["pressure"]].to_dataframe().reset_index()
    within = table.assign(radius=0.1, pressure=0.0).drop_duplicates("time")
    columns = ["time", "radius", "pressure"]
    pandas.concat([table, within])[columns].to_csv("theirs.csv", index=False)
    command("check scene.toml theirs.csv --out out", scene=HOLLOW)
