"""A plan compared with the run that it predicts."""

import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from groups import nightly_but

from ringwear import Scene, SceneError, Stages, method, plan
from ringwear.meshes import structured

BUNDLED = sorted(file.stem for file in (Path(__file__).parents[2] / "studies/scenes").iterdir())


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("name", nightly_but(("five_rings", "sphere"), BUNDLED))
def test_unknowns_are_those_of_the_run(name):
    """They are those of the run before a refinement."""
    scene = Scene.load(name)
    # element sizes do not depend on late times; a large rtol takes less time
    scene = scene.changed(wear__times=scene.wear.times[:3], accuracy__rtol=1e-2)
    for of in scene.methods:
        solution = method(of).solve(scene.problem, Stages(of))
        assert method(of).system_size(scene.problem).unknowns == solution.unknowns


@pytest.mark.parametrize("line", ["plan scene.toml", "run scene.toml --no-figures --verbose"])
def test_no_text_calls_an_elastic_punch_rigid(line, command):
    printed = command(line, scene=Scene.load("pin_on_disc").changed(methods=["direct"])).out
    assert "two elastic bodies" in printed
    assert "rigid" not in printed


def test_a_plan_for_the_mesh_of_another_program(command):
    """The longest stable step is in a line of its own, for a size and for a file."""
    by_size = command("plan five_rings --size 0.1 --element Q2S").out
    (stable,) = [line for line in by_size.splitlines() if line.startswith("stable")]
    assert "sliding distance of 0.00" in stable
    assert "range: " in by_size
    assert "mdr" not in by_size
    meshio.Mesh(*quarter_disc()).write("mine.vtu")
    by_file = command("plan five_rings --mesh mine.vtu").out
    assert "mesh: 10 sides of Q1" in by_file
    assert "range: " not in by_file


def quarter_disc():
    """Return points and cells of a quarter disc in rows and columns, as meshio takes them."""
    mesh = structured.below_nodes(np.linspace(0, 1, 11), 20.0)
    return np.pad(mesh.p.T, ((0, 0), (0, 1))), {"quad": mesh.t.T}


@pytest.mark.parametrize(
    ("options", "remedy"),
    [
        ({"size": 0.1, "mesh": "mine.vtu"}, "give one of them"),
        ({"element": "Q1"}, "give size or mesh, too"),
        ({"size": 0.1, "element": "Q3"}, "element = 'Q3'"),
        ({"size": 7.0}, "in the units of the scene, 0.001 to 1"),
        ({"size": -1.0}, "in the units of the scene"),
        ({"mesh": "missing.msh"}, "missing.msh"),
    ],
    ids=str,
)
def test_unsuitable_meshes_of_other_programs_are_refused(options, remedy):
    with pytest.raises(SceneError, match=re.escape(remedy)):
        plan("five_rings", **options)


def test_layers_have_no_mesh_of_a_size():
    with pytest.raises(SceneError, match="give mesh, a file whose elements do not cross"):
        plan("polishing_pad", size=1e-3)
