"""Structure of the package: folders have one subject, and imports point one way.

Tools and applications import public names of the core, which its rooms list in stubs.
"""

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FLOORS = ("meshes", "mdr", "fem", "studies")
CORE_FOLDERS = ("meshes", "mdr", "fem", "studies/crosscheck")
# Every folder with its subject, from the lowest floor up; folders on the same floor may not
# import each other. Two files stand on floors of their own. The core, which is what it takes
# to run a scene and to judge it, is `meshes`, `mdr`, `fem` and `studies.crosscheck`; above it
# stand tools and applications.
ROOMS: tuple[dict[str, str], ...] = (
    {
        "meshes": "pressure spaces along the radius, and meshes of the half-space",
        "meshes.by_gmsh": "meshes by gmsh",
        "meshes.ground": "elastic layers",
    },
    {
        "mdr": "the half-space in theory: compliances, transforms, closed forms",
        "fem": "the half-space by finite elements",
    },
    {
        "studies.crosscheck": "names, progress and versions, and the public names of the core",
        "studies.tables": "tables and scans as other programs write them, and tables to write",
    },
    {"studies.crosscheck.problem": "the problem without units, its sections and quantities"},
    {"studies.crosscheck.sizes": "sizes and degrees of elements"},
    {"studies.crosscheck.wear": "contact and wear: start, modes, steady state, moving edges"},
    # times of a scene may be counts of its slowest relaxation time
    {"studies.crosscheck.scene": "scenes as users write them, and explanations of their errors"},
    {"studies.crosscheck.methods.sampling": "quantities of histories, norms of differences"},
    {"studies.crosscheck.methods": "methods, their pipeline and their error estimates"},
    {"studies.crosscheck.methods.inside": "fields inside the half-space"},
    {"studies.crosscheck.anchors": "closed forms and balances that correct results satisfy"},
    {"studies.crosscheck.verdict": "agreement of methods, refinement, and what is not promised"},
    {"studies.crosscheck.result.scope": "what a scene models, what is left out, and refusals"},
    {"studies.crosscheck.result.output": "folders and files of results, signals"},
    {"studies.crosscheck.result": "runs and their results: table, answer, summary, words"},
    {"studies.figures": "figures of results"},
    {"studies.report": "pages of results, and their texts on the terminal"},
    {
        "studies.study": "the engine of studies: cases, ways, errors, orders, figures",
        "studies.study.ways": "ways to compute a case: meshes, cells, tolerances, steps",
    },
    {"studies.estimate": "parameters of a scene or a reading that explain numbers, and mistakes"},
    {"studies.wear_step": "the longest stable updates of wear on the meshes of other programs"},
    {
        "studies": "commands, studies, and comparisons of results",
        "studies.challenge": "problems for other programs, and their results",
        "studies.check": "results of other programs against ours",
        "studies.decks": "input files for other programs",
        "studies.examples": "scripts as users write them",
        "studies.fit": "fits of scenes to measurements",
        "studies.paper": "study of the paper",
        "studies.sweep": "sweeps over keys of a scene",
    },
)
# greatest number of files in a chain of imports, at the top of a file or within a function
MOST_FLOORS = 20
# what the core imports from above it, at the first use: figures and pages
UPWARD = {
    "studies.crosscheck.result.result": {
        "studies.figures.catalogue",
        "studies.figures.style",
        "studies.report.page",
    },
    "studies.crosscheck.result.words": {"studies.figures.catalogue"},
}
# packages that the package itself loads at their first use, by name
LOADED_LATE = {
    "studies.crosscheck.methods.base": "methods, of which a scene needs some",
    "studies.documented": "commands and studies, of which a user conducts one",
    "studies.figures.catalogue": "figures, of which a run draws some",
}
# packages without a module, whose files are installed as data
ONLY_DATA = {
    "ringwear.studies.challenge.others",
    "ringwear.studies.scenes",
    "ringwear.studies.sweep.files",
}
FILES = {
    file.relative_to(ROOT).with_suffix("").as_posix().replace("/", "."): file
    for floor in FLOORS
    for file in sorted((ROOT / floor).rglob("*.py"))
    if file.name != "__init__.py"
}

# rooms of the core that list public names, in a stub beside their `__init__.py`
PUBLIC_ROOMS = ("meshes", "meshes.by_gmsh", "mdr", "fem", "studies.crosscheck")


def public_names(room):
    """Return the module in which each public name of a room is defined, by the name."""
    stub = ROOT / room.replace(".", "/") / "__init__.pyi"
    return {
        alias.name: f"{room}.{node.module}" if node.module else f"{room}.{alias.name}"
        for node in ast.walk(ast.parse(stub.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


PUBLIC = {room: public_names(room) for room in PUBLIC_ROOMS}


def statements(tree, types):
    """Yield all nodes of a tree, with or without those that only type checkers read."""
    yield tree
    only_types = isinstance(tree, ast.If) and getattr(tree.test, "id", "") == "TYPE_CHECKING"
    for node in () if only_types and not types else ast.iter_child_nodes(tree):
        yield from statements(node, types)


def imports_in(file, types=True):
    """Yield module and name of everything that a file imports, at its top or within a function.

    Modules of this package are named without `ringwear.`. Without `types`, imports that only type
    checkers read are left out.
    """
    folders = file.parent.relative_to(ROOT).parts
    for node in statements(ast.parse(file.read_text("utf-8")), types):
        if isinstance(node, ast.ImportFrom):
            start = folders[: len(folders) + 1 - node.level] if node.level else ()
            module = ".".join([*start, *filter(None, [node.module])]).removeprefix("ringwear.")
            yield from ((module, alias.name) for alias in node.names)


def imported(file, types=True):
    """Yield the files of ringwear that a file imports."""
    for module, name in imports_in(file, types):
        yield from {module, PUBLIC.get(module, {}).get(name, f"{module}.{name}")} & FILES.keys()


IMPORTS = {name: set(imported(file)) for name, file in FILES.items()}


def floor_of(name):
    """Return the floor of a file, and its room: a folder of that floor with those inside it."""
    rooms = [(floor, room) for floor, rooms in enumerate(ROOMS) for room in rooms]
    inside = [place for place in rooms if f"{name}.".startswith(f"{place[1]}.")]
    floor = max(inside, key=lambda place: len(place[1]))[0]
    return floor, min((room for above, room in inside if above == floor), key=len)


def test_every_folder_has_a_subject():
    folders = {name.rpartition(".")[0] for name in FILES}
    listed = {room for rooms in ROOMS for room in rooms}
    assert folders == listed - {"studies.crosscheck.result.scope"}


def test_modules_are_loaded_by_name_in_few_places():
    """A name in a string is an import that no tool can follow."""
    for name, file in FILES.items():
        loads = "import_module" in file.read_text("utf-8")
        assert loads == (name in LOADED_LATE), name


def test_files_import_from_lower_floors_only():
    for name, others in IMPORTS.items():
        floor, room = floor_of(name)
        for other in others:
            below, its_room = floor_of(other)
            if other not in UPWARD.get(name, ()):
                assert below < floor or its_room == room, f"{name} imports {other}"


def test_the_core_imports_no_more_from_above_than_listed():
    """The list gets shorter, not longer."""
    for name, others in UPWARD.items():
        unused = others - IMPORTS[name]
        assert not unused, f"{name} no longer imports {unused}: remove this from UPWARD"


def test_imports_inside_the_package_are_relative():
    """Editors can follow them in a plain checkout; only examples import as users do."""
    for name, file in FILES.items():
        absolute = re.search(r"^\s*(from|import) ringwear\b", file.read_text("utf-8"), re.MULTILINE)
        assert not absolute or name.startswith("studies.examples."), name


def test_import_chains_are_short():
    """Circular imports would raise a CycleError in the sorter."""
    imports = {
        name: set(imported(file, types=False)) - UPWARD.get(name, set())
        for name, file in FILES.items()
    }
    depth = {}
    for name in TopologicalSorter(imports).static_order():
        depth[name] = 1 + max((depth[other] for other in imports[name]), default=0)
    assert max(depth.values()) <= MOST_FLOORS


def test_every_folder_is_installed():
    """Folders of problems have names that are no names of packages, and are installed as data."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    setuptools = project["tool"]["setuptools"]
    packages = {f"ringwear.{name.rpartition('.')[0]}" for name in FILES}
    assert set(setuptools["packages"]) == {"ringwear"} | packages | ONLY_DATA
    patterns = setuptools["package-data"]["ringwear.studies.challenge"]
    challenge = ROOT / "studies" / "challenge"
    installed = {file for pattern in patterns for file in challenge.glob(pattern)}
    for problem in challenge.glob("[0-9]*"):
        files = {problem} if problem.is_file() else set(problem.iterdir())
        assert installed >= {file for file in files if file.is_file()}


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


@pytest.mark.parametrize(
    ("folder", "names"),
    [("unit", {"run", "check", "sweep", "study", "plan", "main"}), ("physics", {"main"})],
)
def test_unit_tests_make_no_whole_runs_and_only_system_tests_use_the_command_line(folder, names):
    for file in (ROOT / "tests" / folder).rglob("*.py"):
        assert not {("ringwear", name) for name in names} & {*imports_in(file)}, file


def is_in_core(path):
    return any(f"{path}/".startswith(f"{folder}/") for folder in CORE_FOLDERS)


def path_of(module):
    """Return the path of a module or folder without its suffix; None if there is none."""
    path = module.replace(".", "/")
    exists = (ROOT / path).is_dir() or (ROOT / f"{path}.py").is_file()
    return path if path and exists else None


def imports_of(file):
    """Yield module and name of everything that a file imports from this package."""
    for module, name in imports_in(file):
        full = f"{module}.{name}".removeprefix("ringwear.")
        is_module = name not in PUBLIC.get(module, {}) and path_of(full)
        yield (full if is_module else full.rpartition(".")[0]), name


def imports_past_public_names():
    """Yield files of applications with the modules of the core whose other names they import."""
    for folder in FLOORS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            path = file.relative_to(ROOT).as_posix()
            if is_in_core(path):
                continue
            for module, name in imports_of(file):
                is_public = name in PUBLIC.get(module, {})
                if not is_public and path_of(module) and is_in_core(path_of(module)):
                    yield path, module, name


def test_no_import_goes_past_the_public_names():
    """Use a public name instead; what others need may be made public."""
    assert [*imports_past_public_names()] == []


@pytest.mark.parametrize("room", PUBLIC_ROOMS)
def test_public_names_are_loaded_by_their_room(room):
    package = importlib.import_module(f"ringwear.{room}")
    assert sorted(package.__all__) == sorted(PUBLIC[room])
    for name, module in PUBLIC[room].items():
        assert getattr(package, name) is not None
        # the attribute of this name would be the folder or file as soon as that is loaded
        children = {path.stem for path in (ROOT / room.replace(".", "/")).iterdir()}
        assert name not in children or module == f"{room}.{name}"


def test_public_names_are_used_by_others():
    """A name that only the core itself uses is not public."""
    import ringwear

    used = set(ringwear.__all__)
    for folder in ("studies", "tests"):
        for file in (ROOT / folder).rglob("*.py"):
            if not is_in_core(file.relative_to(ROOT).as_posix()):
                used |= {name for _, name in imports_of(file)}
    for room in PUBLIC_ROOMS:
        assert not PUBLIC[room].keys() - used, room


def test_names_that_are_explained_are_public():
    from ringwear.studies import crosscheck

    explained = re.findall(r"^(`.*`)$", crosscheck.__doc__, re.MULTILINE)
    names = {name.strip("`") for line in explained for name in line.split(", ")}
    assert names <= set(crosscheck.__all__)


def test_names_of_ringwear_come_from_the_public_names_of_the_core():
    for name, place in public_names("studies.api").items():
        module = place.removeprefix("studies.api.")
        if is_in_core(module.replace(".", "/")):
            assert module in PUBLIC_ROOMS
            assert name in PUBLIC[module]


def test_the_core_loads_nothing_before_its_first_use():
    code = (
        "import sys, ringwear.studies.crosscheck as core\n"
        "rooms = [name for name in sys.modules if name.startswith(core.__name__ + '.')]\n"
        "assert not rooms and not {'numpy', 'scipy', 'pydantic', 'xarray'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_tests_that_sources_cite_exist():
    for file in FILES.values():
        # a whole file, or one of its tests
        cited = r"((?:physics|unit|system)/[\w/]+\.py)(?:::(test_\w+))?"
        for path, name in re.findall(cited, file.read_text("utf-8")):
            text = (ROOT / "tests" / path).read_text("utf-8")
            assert not name or re.search(rf"^def {name}\(", text, re.MULTILINE), (file, name)


def test_files_that_pages_name_exist():
    files = [f"/{file.relative_to(ROOT).as_posix()}" for file in FILES.values()]
    files += [f"/{file.relative_to(ROOT).as_posix()}" for file in (ROOT / "tests").rglob("*.py")]
    for page in (page for floor in FLOORS for page in (ROOT / floor).rglob("*.md")):
        named = re.findall(r"`([\w/]+\.py)`", page.read_text("utf-8"))
        gone = [name for name in named if not any(file.endswith(f"/{name}") for file in files)]
        assert gone == [], page
