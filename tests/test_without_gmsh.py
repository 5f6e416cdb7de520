"""Where gmsh cannot be loaded, meshes come from bisection, and the remedy is told."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from ringwear import Scene, run
from ringwear.meshes import triangles
from ringwear.meshes.errors import MeshError
from ringwear.meshes.sizes import SizeField
from ringwear.studies.cli import main

PACKAGES = ["libgl1", "libglu1-mesa", "libgomp1", "libxrender1", "libxcursor1", "libxft2", "libxinerama1"]


@pytest.fixture
def _no_gmsh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gmsh", None)


@pytest.mark.gmsh
def test_same_answer_by_bisection(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene.load("five_rings").changed(methods=["fem"], accuracy__rtol=1e-3)
    with_gmsh = run(scene)
    assert with_gmsh.notes == ()
    monkeypatch.setitem(sys.modules, "gmsh", None)
    without = run(scene)
    one, other = (result.solutions["fem"].results.indentation for result in (with_gmsh, without))
    assert abs(one / other - 1).max() <= 1e-3
    assert without.solutions["fem"].settings["mesher"] == "bisection"
    (note,) = without.notes
    assert all(package in note for package in PACKAGES)
    assert without.summary["notes"] == [note]


@pytest.mark.usefixtures("_no_gmsh")
def test_commands_tell_the_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mesh", "flat_punch", "--out", str(tmp_path)]) == 0
    assert "apt-get install" in capsys.readouterr().out


@pytest.mark.usefixtures("_no_gmsh")
def test_the_mesher_itself_refuses() -> None:
    with pytest.raises(MeshError, match="libglu1-mesa"):
        triangles.mesh(SizeField((0.0, 1.0), 1e-2, 1e-2, 0.6, 5.0))
