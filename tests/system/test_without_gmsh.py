"""Where gmsh or CHOLMOD cannot be loaded, others do their work, and the plan says so before, the
result after the run.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from ringwear import Scene, plan, run
from ringwear.meshes import triangles
from ringwear.meshes.errors import MeshError
from ringwear.meshes.sizes import SizeField
from ringwear.studies.cli import main
from ringwear.studies.methods.base import method

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


def of_elements(lines: list[str]) -> list[str]:
    """What a plan says of the finite elements: what they are made of, and what they will cost."""
    (at,) = (number for number, line in enumerate(lines) if line.startswith("fem: "))
    return lines[at : at + 2]


@pytest.mark.parametrize("mesher", ["quads", "gmsh", "bisection"])
def test_the_plan_is_of_what_will_run(
    mesher: str, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"], accuracy__rtol=1e-2, accuracy__fem__mesher=mesher
    )
    replacement = plan(scene.changed(accuracy__fem__mesher="bisection"))
    request.getfixturevalue("_broken_gmsh")
    monkeypatch.setitem(sys.modules, "kvxopt", None)
    lines, result = plan(scene), run(scene)
    notes = [line.removeprefix("note: ") for line in lines if line.startswith("note: ")]
    assert notes == [note for note in result.notes if "refined" not in note]
    assert bool(notes) == (mesher != "bisection")
    assert all("libGL.so.1" in note and "apt-get install" in note for note in notes)
    solution = result.solutions["fem"]
    described, costs = of_elements(lines)
    assert (
        f"triangles by {solution.settings['mesher']}, degree {solution.settings['degree']},"
        in described
    )
    assert described.endswith(f"by {solution.settings['solver']}")
    assert solution.settings["solver"] == "superlu"
    # the same elements and so the same counts as where bisection is asked for
    assert costs.split(" pressures, ")[0] == of_elements(replacement)[1].split(" pressures, ")[0]
    assert 0.5 <= method("fem").cost(scene.problem).unknowns / solution.unknowns <= 2


@pytest.mark.parametrize("mesher", ["quads", "gmsh", "bisection"])
def test_seconds_are_those_of_the_solver(mesher: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The two factorisations were measured apart, and nothing else of the cost depends on them."""
    problem = Scene.load("many_rings").changed(accuracy__fem__mesher=mesher).problem
    monkeypatch.setattr("ringwear.studies.methods.fem.unavailable", lambda: "")
    costs = {}
    for solver in ("cholmod", "superlu"):
        monkeypatch.setattr("ringwear.studies.methods.fem.solver", lambda solver=solver: solver)
        costs[solver] = method("fem").cost(problem)
    one, other = costs["cholmod"], costs["superlu"]
    assert 0 < one.seconds != other.seconds > 0
    assert replace(one, seconds=0.0, error=0.0) == replace(other, seconds=0.0, error=0.0)
    assert one.error == pytest.approx(other.error, rel=1e-3)
