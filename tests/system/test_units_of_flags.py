"""Numbers of the command line with units, as numbers of a scene have them."""

import pytest

from ringwear import main

SCENE = """
units = "mm, N, MPa, s"
methods = ["mdr"]
[punch]
radius = 10.0
wear_coefficient = 1e-9
[half_space]
plane_strain_modulus = 1000.0
[load]
normal_force = 100.0
sliding_speed = 100.0
[wear]
times = [0.0, 3600.0]
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(SCENE, "utf-8")
    return str(path)


def printed(capsys, *call):
    assert main([*call]) == 0
    return capsys.readouterr().out


def test_a_size_may_have_a_unit(scene, capsys):
    plain = printed(capsys, "plan", scene, "--size", "0.5")
    assert printed(capsys, "plan", scene, "--size", "500 um") == plain
    assert printed(capsys, "plan", scene, "--size", "0.5 mm") == plain
    assert main(["plan", scene, "--size", "0.5 s"]) == 2
    assert "--size = '0.5 s' is no length" in capsys.readouterr().err


def test_a_time_and_a_radius_in_punch_radii_may_have_units(scene, tmp_path, capsys):
    decks = []
    for name, flags in (
        ("plain", ["--time", "3600", "--reach", "100"]),
        ("units", ["--time", "1 h", "--reach", "1 m"]),
    ):
        printed(capsys, "deck", scene, "--for", "calculix", *flags, "--out", str(tmp_path / name))
        decks.append((tmp_path / name / "prescribed.inp").read_text("utf-8"))
    assert decks[0] == decks[1]


def test_times_of_tables_have_the_units_of_the_tables(scene, tmp_path, capsys):
    depth = 100 / (2 * 10 * 1000)
    for name, unit in (("mm", 1.0), ("m", 1e-3)):
        path = tmp_path / f"{name}.csv"
        path.write_text(f"radius,displacement\n0,{depth * unit}\n{5 * unit},{depth * unit}\n")
    out = ["--out", str(tmp_path / "out")]
    for name, more in (("mm", []), ("m", ["--units", "m, N, Pa, s"])):
        call = ["check", scene, str(tmp_path / f"{name}.csv"), "--time", "0 min", *more, *out]
        assert "displacement: no error found" in printed(capsys, *call)


def test_values_of_a_key_may_have_units(scene):
    from ringwear import Scene
    from ringwear.studies.extremes import values_of_keys

    texts = ["punch.radius=geom:1 cm:1 m:3", "half_space.poisson_ratio=0.3:0.5:2"]
    values = {"punch.radius": [10, 100, 1000], "half_space.poisson_ratio": [0.3, 0.5]}
    assert values_of_keys(Scene.load(scene), texts, False) == values


def test_the_mesh_of_a_plan_has_its_own_unit(tmp_path, capsys):
    import meshio
    import numpy as np

    from ringwear import Scene
    from ringwear.studies.crosscheck import fem_sizes

    mesh = fem_sizes(Scene.load("flat_punch").problem).mesh
    points = np.column_stack([1e3 * mesh.p.T, np.zeros(mesh.p.shape[1])])
    kind = "triangle" if len(mesh.t) == 3 else "quad"
    path = tmp_path / "mesh.vtu"
    meshio.write(path, meshio.Mesh(points, [(kind, mesh.t.T)]))
    call = ["plan", "flat_punch", "--mesh", str(path)]
    assert main(call) == 2
    assert "give their unit by --units" in capsys.readouterr().err
    assert "stable: at most" in printed(capsys, *call, "--units", "1e-3")
