"""Numbers of the command line with units, as numbers of a scene have them."""

import meshio
import numpy as np

from ringwear import Scene
from ringwear.studies.crosscheck import fem_sizes
from ringwear.studies.extremes import values_of_keys

SCENE = Scene.from_toml("""
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
""")


def test_a_size_may_have_a_unit(command):
    plain = command("plan scene.toml --size 0.5", scene=SCENE).out
    assert command("plan scene.toml --size '500 um'").out == plain
    assert command("plan scene.toml --size '0.5 mm'").out == plain
    assert "--size = '0.5 s' is no length" in command("plan scene.toml --size '0.5 s'", 2).err


def test_a_time_and_a_radius_in_punch_radii_may_have_units(command, tmp_path):
    decks = []
    for flags in ("--time 3600 --reach 100", "--time '1 h' --reach '1 m'"):
        command(f"deck scene.toml --for calculix {flags} --out out", scene=SCENE)
        decks.append((tmp_path / "out" / "prescribed.inp").read_text("utf-8"))
    assert decks[0] == decks[1]


def test_times_of_tables_have_the_units_of_the_tables(command, tmp_path):
    depth = 100 / (2 * 10 * 1000)
    for name, unit in (("mm", 1.0), ("m", 1e-3)):
        path = tmp_path / f"{name}.csv"
        path.write_text(f"radius,displacement\n0,{depth * unit}\n{5 * unit},{depth * unit}\n")
    for flags in ("mm.csv", "m.csv --units 'm, N, Pa, s'"):
        output = command(f"check scene.toml {flags} --time '0 min' --out out", scene=SCENE).out
        assert "displacement: no error found" in output


def test_values_of_a_key_may_have_units():
    texts = ["punch.radius=geom:1 cm:1 m:3", "half_space.poisson_ratio=0.3:0.5:2"]
    values = {"punch.radius": [10, 100, 1000], "half_space.poisson_ratio": [0.3, 0.5]}
    assert values_of_keys(SCENE, texts, False) == values


def test_the_mesh_of_a_plan_has_its_own_unit(command):
    mesh = fem_sizes(Scene.load("flat_punch").problem).mesh
    points = np.column_stack([1e3 * mesh.p.T, np.zeros(mesh.p.shape[1])])
    kind = "triangle" if len(mesh.t) == 3 else "quad"
    meshio.write("mesh.vtu", meshio.Mesh(points, [(kind, mesh.t.T)]))
    plan = "plan flat_punch --mesh mesh.vtu"
    assert "give their unit by --units" in command(plan, 2).err
    assert "stable: at most" in command(f"{plan} --units 1e-3").out
