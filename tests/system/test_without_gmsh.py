"""Where gmsh or CHOLMOD cannot be loaded, others do their work, and the plan says so before, the
result after the run.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from ringwear import Scene, plan, run
from ringwear.meshes import triangles
from ringwear.meshes.errors import MeshError
from ringwear.meshes.sizes import SizeField
from ringwear.studies.cli import main

PACKAGES = [
    "libgl1",
    "libglu1-mesa",
    "libgomp1",
    "libxrender1",
    "libxcursor1",
    "libxft2",
    "libxinerama1",
]


@pytest.fixture
def _no_gmsh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gmsh", None)


@pytest.mark.gmsh
def test_same_answer_by_bisection(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene.load("five_rings").changed(methods=["fem"], accuracy__rtol=1e-3)
    with_gmsh = run(scene)
    assert not any("meshed by" in note for note in with_gmsh.notes)
    monkeypatch.setitem(sys.modules, "gmsh", None)
    without = run(scene)
    one, other = (result.solutions["fem"].results.indentation for result in (with_gmsh, without))
    assert abs(one / other - 1).max() <= 1e-3
    assert without.solutions["fem"].settings["mesher"] == "bisection"
    note = without.notes[0]
    assert all(package in note for package in PACKAGES)
    assert list(without.summary["notes"]) == list(without.notes)


@pytest.mark.usefixtures("_no_gmsh")
def test_commands_tell_the_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mesh", "flat_punch", "--out", str(tmp_path)]) == 0
    assert "apt-get install" in capsys.readouterr().out


@pytest.mark.usefixtures("_no_gmsh")
def test_the_mesher_itself_refuses() -> None:
    with pytest.raises(MeshError, match="libglu1-mesa"):
        triangles.mesh(SizeField((0.0, 1.0), 1e-2, 1e-2, 0.6, 5.0))


@pytest.fixture
def _broken_gmsh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """gmsh as pip installs it on a system without its libraries."""
    (tmp_path / "gmsh.py").write_text(
        'raise OSError("libGL.so.1: cannot open shared object file")\n', "utf-8"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)


@pytest.mark.parametrize("mesher", ["quads", "gmsh", "bisection"])
def test_the_plan_is_of_what_will_run(
    mesher: str, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"], accuracy__rtol=1e-3, accuracy__fem__mesher=mesher
    )
    request.getfixturevalue("_broken_gmsh")
    monkeypatch.setitem(sys.modules, "kvxopt", None)
    lines, result = plan(scene), run(scene)
    notes = [line.removeprefix("note: ") for line in lines if line.startswith("note: ")]
    assert notes == [note for note in result.notes if "refined" not in note]
    assert bool(notes) == (mesher != "bisection")
    assert all("libGL.so.1" in note and "apt-get install" in note for note in notes)
    settings = result.solutions["fem"].settings
    assert settings["solver"] == "superlu"
    assert settings["mesher"] == "bisection"
    counted = f"fem: {result.solutions['fem'].unknowns} unknowns, "
    assert any(line.startswith(counted) for line in lines)
