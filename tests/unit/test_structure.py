"""The house: data flows one way, and only what a job needs is loaded."""

import ast
import subprocess
import sys
import tomllib
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# the rooms from the ground up; what stands in one line may not import each other
ROOMS = (
    {"meshes"},
    {"mdr", "fem"},
    {"studies.registry", "studies.progress", "studies.versions"},
    {"studies.tables", "studies.problem"},
    {"studies.wear"},
    {"studies.problem.scene"},  # times of a scene may be counts of its slowest relaxation time
    {"studies.methods"},
    {"studies.crosscheck"},
    {"studies.figures"},
    {"studies.report"},
    {"studies.output"},
    {"studies"},  # the studies themselves and the command line
)
FILES = {
    file.relative_to(ROOT).with_suffix("").as_posix().replace("/", "."): file
    for floor in ("meshes", "mdr", "fem", "studies")
    for file in sorted((ROOT / floor).rglob("*.py"))
    if file.name != "__init__.py"
}


def imported(file):
    """Files of ringwear that a file imports, at its top or within a function: by folders, so that
    editors follow them in a plain checkout.
    """
    apart = file.parent in (ROOT / "studies" / "api", ROOT / "studies" / "examples")
    folders = file.parent.relative_to(ROOT).parts
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom):
            module = str(node.module or "")
            if node.level:
                module = ".".join(
                    (*folders[: len(folders) - node.level + 1], *filter(None, [module]))
                )
            else:
                assert apart or not module.startswith("ringwear"), f"{file}: an absolute import"
            names = (module, *(f"{module}.{alias.name}" for alias in node.names))
        else:
            names = (
                tuple(alias.name for alias in node.names) if isinstance(node, ast.Import) else ()
            )
        yield from (short for name in names if (short := name.removeprefix("ringwear.")) in FILES)


IMPORTS = {name: sorted(set(imported(file))) for name, file in FILES.items()}


def floor_of(name):
    """Floor and room of a file: those of the longest room name that it begins with."""
    rooms = [(floor, room) for floor, rooms in enumerate(ROOMS) for room in rooms]
    return max(
        (place for place in rooms if f"{name}.".startswith(f"{place[1]}.")),
        key=lambda place: len(place[1]),
    )


@pytest.mark.parametrize("name", FILES)
def test_imports_go_down(name):
    floor, room = floor_of(name)
    for other in IMPORTS[name]:
        below, its_room = floor_of(other)
        assert below < floor or its_room == room, f"{name} imports {other}"


def test_no_circle_of_imports():
    order = list(TopologicalSorter(IMPORTS).static_order())
    assert set(order) == set(FILES)


def test_nothing_has_grown_too_large():
    depth = {}
    for name in TopologicalSorter(IMPORTS).static_order():
        depth[name] = 1 + max((depth[other] for other in IMPORTS[name]), default=0)
    assert max(depth.values()) < 12
    assert max(len(file.read_text("utf-8").splitlines()) for file in FILES.values()) <= 400
    folders = Counter(file.parent for file in FILES.values())
    assert max(folders.values()) <= 12


def test_every_room_is_installed():
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"][
        "packages"
    ]
    rooms = {
        "ringwear." + file.parent.relative_to(ROOT).as_posix().replace("/", ".")
        for file in FILES.values()
    }
    assert set(listed) == {"ringwear"} | rooms


@pytest.mark.gmsh
def test_the_default_finite_elements_are_those_of_scikit_fem():
    from skfem import ElementQuadP, MeshQuad
    from skfem.assembly import Dofs

    from ringwear import Scene
    from ringwear.studies.methods.fem import METHOD
    from ringwear.studies.progress import Stages

    problem = Scene.load("five_rings").problem
    half_space = METHOD.discretise(problem, Stages("fem")).half_space
    assert half_space is not None
    solid = half_space.solid
    assert type(solid.mesh) is MeshQuad
    assert set(solid.mesh.boundaries) == {"contact", "free", "axis", "far"}
    assert type(solid.element) is ElementQuadP
    assert {type(batch.element) for batch in solid.batches} == {ElementQuadP}
    assert type(solid.dofs) is Dofs


def loaded(code):
    """Top-level modules that a fresh interpreter has after running the code."""
    tail = "\nimport sys\nprint('\\n' + ' '.join({name.split('.')[0] for name in sys.modules}))"
    done = subprocess.run(
        [sys.executable, "-c", code + tail], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return set(done.stdout.splitlines()[-1].split())


HEAVY = {"gmsh", "skfem", "matplotlib", "meshio", "kvxopt"}


def test_a_scene_needs_no_numerics():
    code = "from ringwear import Scene\nScene.load('five_rings')"
    assert not loaded(code) & (HEAVY | {"scipy", "xarray", "netCDF4"})


@pytest.mark.parametrize("methods", [["direct"], ["mdr"], ["mdr", "direct"]], ids=str)
def test_runs_without_elements_load_no_mesher(methods):
    code = (
        "from ringwear import Scene, "
        f"run\nrun(Scene.load('five_rings').changed(methods={methods})).summary"
    )
    assert not loaded(code) & HEAVY


def test_elements_by_bisection_load_no_gmsh():
    changes = "methods=['fem'], accuracy__fem__mesher='bisection', accuracy__rtol=1e-2"
    modules = loaded(
        f"from ringwear import Scene, run\nrun(Scene.load('flat_punch').changed({changes}))"
    )
    assert "skfem" in modules
    assert not modules & {"gmsh", "matplotlib", "meshio"}


@pytest.mark.parametrize(
    "arguments", [["--help"], ["run", "--help"], ["study", "--help"], ["scenes"]], ids=str
)
def test_help_is_light(arguments):
    code = f"from ringwear.studies.cli import main\ntry:\n    main({arguments})\n"
    code += "except SystemExit as end:\n    assert not end.code"
    assert not loaded(code) & (HEAVY | {"scipy", "xarray", "netCDF4", "threadpoolctl"})


def test_a_refusal_by_memory_computes_nothing(tmp_path):
    arguments = ["run", "five_rings", "--memory", "0.1", "--out", str(tmp_path / "out")]
    code = f"from ringwear.studies.cli import main\nassert main({arguments}) == 2"
    assert not loaded(code) & (HEAVY | {"xarray", "netCDF4", "threadpoolctl"})
