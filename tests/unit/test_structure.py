"""Structure of the package: imports point one way, and their chains are short."""

import ast
import re
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# packages and modules from the lowest floor up; those on the same floor may not import each other
ROOMS = (
    {"meshes"},
    {"mdr", "fem"},
    {"studies.registry", "studies.progress", "studies.versions"},
    {"studies.tables", "studies.problem"},
    {"studies.sizes"},
    {"studies.wear"},
    {"studies.contact"},
    {"studies.scene"},  # times of a scene may be counts of its slowest relaxation time
    {"studies.sampling"},
    {"studies.methods"},
    {"studies.inside"},
    {"studies.anchors"},
    {"studies.crosscheck"},
    {"studies.outcome"},
    {"studies.predictions"},
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
    """Yield the files of ringwear that a file imports, at its top or within a function."""
    folders = file.parent.relative_to(ROOT).parts
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            start = folders[: len(folders) + 1 - node.level]
            module = ".".join([*start, node.module] if node.module else start)
            yield from {module, *(f"{module}.{alias.name}" for alias in node.names)} & FILES.keys()


IMPORTS = {name: set(imported(file)) for name, file in FILES.items()}


def floor_of(name):
    """Return floor and room of a file; the room is the longest one that its name begins with."""
    rooms = [(floor, room) for floor, rooms in enumerate(ROOMS) for room in rooms]
    return max(
        (place for place in rooms if f"{name}.".startswith(f"{place[1]}.")),
        key=lambda place: len(place[1]),
    )


def test_files_import_from_lower_floors_only():
    for name, others in IMPORTS.items():
        floor, room = floor_of(name)
        for other in others:
            below, its_room = floor_of(other)
            assert below < floor or its_room == room, f"{name} imports {other}"


def test_imports_inside_the_package_are_relative():
    """Editors can follow them in a plain checkout; only examples import as users do."""
    for name, file in FILES.items():
        absolute = re.search(r"^\s*(from|import) ringwear\b", file.read_text("utf-8"), re.MULTILINE)
        assert not absolute or name.startswith("studies.examples."), name


def test_import_chains_are_short():
    """Circular imports would raise a CycleError in the sorter."""
    depth = {}
    for name in TopologicalSorter(IMPORTS).static_order():
        depth[name] = 1 + max((depth[other] for other in IMPORTS[name]), default=0)
    assert max(depth.values()) <= 16


def test_every_folder_is_installed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    rooms = {"ringwear." + name.rpartition(".")[0] for name in FILES}
    assert set(project["tool"]["setuptools"]["packages"]) == {"ringwear"} | rooms


@pytest.mark.gmsh
def test_the_default_finite_elements_are_those_of_scikit_fem():
    from skfem import ElementQuadP, MeshQuad
    from skfem.assembly import Dofs

    from ringwear import Scene, Stages, method
    from ringwear.meshes.half_space import ExactQuads

    problem = Scene.load("flat_punch").problem
    solid = method("fem").discretise(problem, Stages("fem")).half_space.solid
    # scikit-fem's mesh, extended by the rounding errors of the radii
    assert type(solid.mesh) is ExactQuads
    assert issubclass(ExactQuads, MeshQuad)
    assert set(solid.mesh.boundaries) == {"contact", "free", "axis", "far"}
    assert type(solid.element) is ElementQuadP
    assert type(solid.dofs) is Dofs


def names_imported(folder):
    """Yield file, module and name of everything that tests of a folder import from ringwear."""
    for file in sorted((ROOT / "tests" / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("ringwear"):
                yield from ((file.name, node.module, alias.name) for alias in node.names)


def test_unit_tests_make_no_whole_runs():
    whole = {"run", "check", "sweep", "study", "plan"}
    imports = [of for of in names_imported("unit") if of[1] == "ringwear" and of[2] in whole]
    assert not imports


def test_only_system_tests_use_the_command_line():
    for folder in ("unit", "physics"):
        assert ("ringwear", "main") not in {of[1:] for of in names_imported(folder)}, folder
