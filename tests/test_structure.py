"""The house: data flows one way, and only what a job needs is loaded."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
# what each floor may import of the others
BELOW = {"meshes": set(), "mdr": {"meshes"}, "fem": {"meshes"}, "studies": {"meshes", "mdr", "fem"}}
FILES = {
    f"ringwear.{file.relative_to(ROOT).with_suffix('').as_posix().replace('/', '.')}": file
    for floor in BELOW
    for file in sorted((ROOT / floor).rglob("*.py"))
    if file.name != "__init__.py"
}


def imported(file: Path) -> Iterator[str]:
    """Files of ringwear that a file imports, at its top or within a function."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in FILES)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import"
            names = (str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names))
            yield from (name for name in names if name in FILES)


IMPORTS = {name: sorted(set(imported(file))) for name, file in FILES.items()}


@pytest.mark.parametrize("name", FILES)
def test_imports_go_down(name: str) -> None:
    floor = name.split(".")[1]
    assert {other.split(".")[1] for other in IMPORTS[name]} <= BELOW[floor] | {floor}


@pytest.mark.gmsh
def test_the_default_finite_elements_are_those_of_scikit_fem() -> None:
    from ringwear import Scene
    from ringwear.studies.methods.fem import fem_model
    from ringwear.studies.progress import Stages
    from skfem import ElementQuadP, MeshQuad
    from skfem.assembly import Dofs

    half_space = fem_model(Scene.load("five_rings").natural, Stages("fem"), twins=False).half_space
    assert half_space is not None
    solid = half_space.solid
    assert type(solid.mesh) is MeshQuad
    assert set(solid.mesh.boundaries) == {"contact", "free", "axis", "far"}
    assert type(solid.element) is ElementQuadP
    assert {type(batch.element) for batch in solid.batches} == {ElementQuadP}
    assert type(solid.dofs) is Dofs


def loaded(code: str) -> set[str]:
    """Top-level modules that a fresh interpreter has after running the code."""
    tail = "\nimport sys\nprint('\\n' + ' '.join({name.split('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", code + tail], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stdout.splitlines()[-1].split())


HEAVY = {"gmsh", "skfem", "matplotlib", "meshio", "kvxopt"}


def test_a_scene_needs_no_numerics() -> None:
    code = "from ringwear import Scene\nScene.load('five_rings')"
    assert not loaded(code) & (HEAVY | {"scipy", "xarray", "netCDF4"})


@pytest.mark.parametrize("methods", [["direct"], ["mdr"], ["mdr", "direct"]], ids=str)
def test_runs_without_elements_load_no_mesher(methods: list[str]) -> None:
    code = f"from ringwear import Scene, run\nrun(Scene.load('five_rings').changed(methods={methods})).summary"
    assert not loaded(code) & HEAVY


def test_elements_by_bisection_load_no_gmsh() -> None:
    changes = "methods=['fem'], accuracy__fem__mesher='bisection', accuracy__rtol=1e-2"
    found = loaded(f"from ringwear import Scene, run\nrun(Scene.load('flat_punch').changed({changes}))")
    assert "skfem" in found
    assert not found & {"gmsh", "matplotlib", "meshio"}


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["study", "--help"], ["scenes"]], ids=str)
def test_help_is_light(arguments: list[str]) -> None:
    code = f"from ringwear.studies.cli import main as m\ntry:\n    m({arguments})\nexcept SystemExit as end:\n    assert not end.code"
    assert not loaded(code) & (HEAVY | {"scipy", "xarray", "netCDF4", "threadpoolctl"})


def test_a_plan_computes_nothing() -> None:
    assert not loaded("from ringwear.studies.cli import main\nassert main(['plan', 'five_rings']) == 0") & HEAVY
