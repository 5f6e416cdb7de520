"""Runs without gmsh or CHOLMOD use replacements, which the plan and the result report."""

import sys

import numpy as np
import pytest

from ringwear import Scene, plan, run
from ringwear.meshes.by_gmsh import triangles
from ringwear.meshes.errors import MeshError
from ringwear.meshes.sizes import SizeField
from ringwear.studies.cli import main


@pytest.fixture(autouse=True)
def _broken_gmsh(monkeypatch, tmp_path):
    """Replace gmsh by one as pip installs it on a system without its libraries."""
    reason = "libGL.so.1: cannot open shared object file"
    (tmp_path / "gmsh.py").write_text(f'raise OSError("{reason}")', "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)


def test_the_remedy_is_printed(tmp_path, capsys):
    assert main(["mesh", "flat_punch", "--out", str(tmp_path / "out")]) == 0
    assert "apt-get install" in capsys.readouterr().out
    with pytest.raises(MeshError, match="libglu1-mesa"):
        triangles.mesh(SizeField((0.0, 1.0), 1e-2, 1e-2, 0.6, 5.0))


@pytest.mark.parametrize("mesher", ["quads", "gmsh", "bisection"])
def test_the_plan_has_the_mesher_of_the_run(mesher, monkeypatch):
    # on triangles, other quantities would be refined, which the plan cannot know
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"],
        accuracy={"rtol": 1e-3, "fem": {"mesher": mesher}},
        output__quantities=["indentation"],
    )
    monkeypatch.setitem(sys.modules, "kvxopt", None)
    lines, result = plan(scene), run(scene)
    exact, by_elements = result.dataset.indentation
    np.testing.assert_allclose(by_elements, exact, rtol=1e-3)
    notes = [line.removeprefix("note: ") for line in lines if line.startswith("note: ")]
    assert notes == list(result.notes)
    assert list(result.summary["notes"]) == list(result.notes)
    assert bool(notes) == (mesher != "bisection")
    assert all("libGL.so.1" in note and "apt-get install" in note for note in notes)
    settings = result.solutions["fem"].settings
    assert (settings["mesher"], settings["solver"]) == ("bisection", "superlu")
    counted = f"fem: {result.solutions['fem'].unknowns} unknowns, "
    assert any(line.startswith(counted) for line in lines)
