"""Each row of the table of cases in the README runs."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from ringwear import Scene, SizeField, bisection, run

README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
# base scene, shorter than that of the README, to which each row of the table is applied
BASE = """
units = "SI"
methods = ["mdr"]
[punch]
radius = "10 mm"
wear_coefficient = "1e-6 mm^3/(N m)"
[half_space]
youngs_modulus = "2 GPa"
[load]
normal_force = "100 N"
sliding_speed = "0.1 m/s"
[wear]
times = ["0 s", "1 h"]
[accuracy]
rtol = 1e-2
"""


def rows():
    table = README.partition("| your case |")[2].partition("\n\n")[0]
    return [
        (line.split("|")[1].strip(), re.search(r"`([^`]+)`", line.split("|")[2]).group(1))
        for line in table.splitlines()[2:]
    ]


SCENES = [row for row in rows() if not row[1].startswith("ringwear")]


def test_the_table_has_the_usual_cases():
    cases = " ".join(case for case, _ in rows())
    for word in ("ball", "elastic bodies", "rotates", "both bodies", "washer", "rounded edge"):
        assert word in cases
    for word in ("given displacement", "start and stop", "mesh of mine", "results of mine", "pad"):
        assert word in cases


@pytest.mark.parametrize("keys", [pytest.param(keys, id=case) for case, keys in SCENES])
def test_a_row_of_the_table_runs(keys):
    table = tomllib.loads(BASE)
    for name, value in tomllib.loads(keys).items():
        whole = keys.startswith(f"{name} =")
        table[name] = value if whole else table.get(name, {}) | value
    result = run(Scene.from_table(table))
    assert result.verdict != "disagree"
    assert all(anchor["holds"] for anchor in result.summary["anchors"])


def test_the_row_of_own_results(command):
    Path("punch.toml").write_text(BASE)
    data = run(Scene.from_toml(BASE)).dataset.isel(solver=0)
    data[["indentation"]].to_dataframe().reset_index()[["time", "indentation"]].to_csv(
        "theirs.csv", index=False
    )
    (line,) = [keys for case, keys in rows() if case == "results of mine"]
    command(line.removeprefix("ringwear "))


@pytest.mark.slow
def test_the_row_of_an_own_mesh(command):
    Path("punch.toml").write_text(BASE)
    field = SizeField((0.0, 1.0), 0.05, 0.05, 0.6, 4.0)
    mesh = bisection.mesh(field)
    mesh.scaled(0.01).save("mine.msh")
    (line,) = [keys for case, keys in rows() if case == "a mesh of mine"]
    command(f"{line.removeprefix('ringwear ')} --quick")


def test_the_row_of_own_measurements(command):
    text = BASE.replace("wear_coefficient =", "rings = 3\nwear_ratio = 10.0\nwear_coefficient =")
    Path("punch.toml").write_text(text)
    data = run(Scene.from_toml(text).changed(wear__times="running-in")).dataset.isel(solver=0)
    table = data[["indentation"]].to_dataframe().reset_index()[["time", "indentation"]]
    table["indentation"] *= 1 + 0.01 * np.random.default_rng(1).normal(size=len(table))
    table.to_csv("measured.csv", index=False)
    (line,) = [keys for _, keys in rows() if keys.startswith("ringwear fit")]
    command(f"{line.removeprefix('ringwear ')} --noise '1 %'")


def test_the_row_of_an_input_file(command):
    Path("punch.toml").write_text(BASE)
    (line,) = [keys for _, keys in rows() if keys.startswith("ringwear deck")]
    command(f"{line.removeprefix('ringwear ')} --size 5e-3 --out deck")
    assert Path("deck/README.md").exists()
