"""The house: data flows one way, and only what a job needs is loaded."""

import ast
import re
import sys
import tomllib
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from graphlib import TopologicalSorter
from multiprocessing import get_context
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# the rooms from the ground up; what stands in one line may not import each other
ROOMS = (
    {"meshes"},
    {"mdr", "fem"},
    {"studies.registry", "studies.progress", "studies.versions"},
    {"studies.tables", "studies.problem"},
    {"studies.sizes"},
    {"studies.wear"},
    {"studies.contact"},
    {"studies.problem.scene"},  # times of a scene may be counts of its slowest relaxation time
    {"studies.sampling"},
    {"studies.methods"},
    {"studies.inside"},
    {"studies.anchors"},
    {"studies.crosscheck"},
    {"studies.figures"},
    {"studies.output"},
    {"studies.report"},
    {"studies"},  # the studies themselves and the command line
)
FILES = {
    file.relative_to(ROOT).with_suffix("").as_posix().replace("/", "."): file
    for floor in ("meshes", "mdr", "fem", "studies")
    for file in sorted((ROOT / floor).rglob("*.py"))
    if file.name != "__init__.py"
}


def imported(file):
    """Files of ringwear that a file imports, at its top or within a function."""
    folders = file.parent.relative_to(ROOT).parts
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            start = folders[: len(folders) + 1 - node.level]
            module = ".".join([*start, node.module] if node.module else start)
            yield from {module, *(f"{module}.{alias.name}" for alias in node.names)} & FILES.keys()


IMPORTS = {name: set(imported(file)) for name, file in FILES.items()}


def floor_of(name):
    """Floor and room of a file: those of the longest room name that it begins with."""
    rooms = [(floor, room) for floor, rooms in enumerate(ROOMS) for room in rooms]
    return max(
        (place for place in rooms if f"{name}.".startswith(f"{place[1]}.")),
        key=lambda place: len(place[1]),
    )


def test_imports_go_down():
    for name, others in IMPORTS.items():
        floor, room = floor_of(name)
        for other in others:
            below, its_room = floor_of(other)
            assert below < floor or its_room == room, f"{name} imports {other}"


def test_imports_go_by_folders():
    """So that editors follow them in a plain checkout; examples are what users write."""
    for name, file in FILES.items():
        absolute = re.search(r"^\s*(from|import) ringwear\b", file.read_text("utf-8"), re.MULTILINE)
        assert not absolute or name.startswith("studies.examples."), name


def test_nothing_has_grown_too_large():
    """Nor goes in circles, of which the sorter would tell."""
    depth = {}
    for name in TopologicalSorter(IMPORTS).static_order():
        depth[name] = 1 + max((depth[other] for other in IMPORTS[name]), default=0)
    assert max(depth.values()) <= 15
    assert max(len(file.read_text("utf-8").splitlines()) for file in FILES.values()) <= 400
    folders = Counter(file.parent for file in FILES.values())
    assert max(folders.values()) <= 12


def test_every_room_is_installed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    rooms = {"ringwear." + name.rpartition(".")[0] for name in FILES}
    assert set(project["tool"]["setuptools"]["packages"]) == {"ringwear"} | rooms


@pytest.mark.gmsh
def test_the_default_finite_elements_are_those_of_scikit_fem():
    from skfem import ElementQuadP, MeshQuad
    from skfem.assembly import Dofs

    from ringwear import Scene, run
    from ringwear.meshes.half_space import ExactQuads

    solid = run(Scene.load("flat_punch"), methods=["fem"]).solutions["fem"].half_space.solid
    # scikit-fem's, and low parts of the radii beside its rounded ones
    assert type(solid.mesh) is ExactQuads
    assert issubclass(ExactQuads, MeshQuad)
    assert set(solid.mesh.boundaries) == {"contact", "free", "axis", "far"}
    assert type(solid.element) is ElementQuadP
    assert type(solid.dofs) is Dofs


def load_step_by_step(out):
    """Do light jobs first; none of them loads what it does not need."""
    import ringwear
    from ringwear.studies.cli import main

    def assert_absent(modules):
        assert not {name.split(".")[0] for name in sys.modules} & set(modules.split())

    scene = ringwear.Scene.load("five_rings").changed(accuracy__rtol=1e-2)
    assert main(["scenes"]) == 0
    for command in ([], ["run"], ["study"]):
        with pytest.raises(SystemExit, match="0"):
            main([*command, "--help"])
    heavy = "gmsh skfem matplotlib meshio kvxopt"
    assert_absent(f"{heavy} scipy xarray netCDF4 threadpoolctl")
    assert main(["run", "five_rings", "--memory", "0.1", "--out", out]) == 2
    assert_absent(f"{heavy} xarray netCDF4 threadpoolctl")
    ringwear.run(scene.changed(methods=["mdr", "direct"]))
    assert_absent(heavy)
    ringwear.run(scene.changed(methods=["fem"], accuracy__fem__mesher="bisection"))
    assert_absent("gmsh matplotlib meshio")


def run_direct_alone(out):
    """Run the steady state alone, without figures and with them."""
    from ringwear.studies.cli import main

    def loaded():
        return {name.split(".")[0] for name in sys.modules}

    command = ["run", "five_rings", "--methods", "direct", "--out"]
    assert main([*command, f"{out}_numbers", "--no-figures"]) == 0
    assert not loaded() & {"gmsh", "skfem", "matplotlib", "meshio", "kvxopt"}
    assert main([*command, f"{out}_figures"]) == 0
    assert not loaded() & {"gmsh", "skfem", "meshio", "kvxopt"}
    assert "matplotlib.pyplot" not in sys.modules


@pytest.mark.parametrize("job", [load_step_by_step, run_direct_alone])
def test_only_what_a_job_needs_is_loaded(tmp_path, job):
    with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
        fresh.submit(job, str(tmp_path / "out")).result()
