"""Applications import public names of the core; what goes past these is listed.

The core is `meshes`, `mdr`, `fem` and `studies/crosscheck`. `past_public_names.txt` has a line for
each file of the other parts and each module of the core that it imports otherwise. The list gets
shorter, not longer.
"""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest
from test_structure import CORE, PUBLIC, ROOT

from ringwear.studies import crosscheck

LIST = Path(__file__).with_name("past_public_names.txt")
FOLDERS = ("meshes", "mdr", "fem", "studies")
CORE_FOLDERS = ("meshes", "mdr", "fem", "studies/crosscheck")


def is_in_core(path):
    return any(f"{path}/".startswith(f"{folder}/") for folder in CORE_FOLDERS)


def path_of(module):
    """Return the path of a module or folder without its suffix; None if there is none."""
    path = module.replace(".", "/")
    exists = (ROOT / path).is_dir() or (ROOT / f"{path}.py").is_file()
    return path if path and exists else None


def imports_of(file):
    """Yield module and name of everything that a file imports from this package."""
    folders = file.parent.relative_to(ROOT).parts
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom):
            start = folders[: len(folders) + 1 - node.level] if node.level else ()
            module = ".".join([*start, node.module] if node.module else start)
            for alias in node.names:
                full = f"{module}.{alias.name}".removeprefix("ringwear.")
                is_module = alias.name not in PUBLIC and path_of(full)
                yield (full if is_module else full.rpartition(".")[0]), alias.name


def imports_past_public_names():
    """Return files of applications, and modules of the core, with the names that they import."""
    past = {}
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            path = file.relative_to(ROOT).as_posix()
            if is_in_core(path):
                continue
            for module, name in imports_of(file):
                if module != CORE and path_of(module) and is_in_core(path_of(module)):
                    past.setdefault((path, module), []).append(name)
    return past


def as_line(path, module):
    return f"{path} -> {module}"


PAST = imports_past_public_names()
LISTED = LIST.read_text("utf-8").splitlines()


def test_the_list_is_sorted_and_has_each_line_once():
    assert sorted(set(LISTED)) == LISTED


def public_among(place):
    """Return the public names among those that a file imports from the module that has them."""
    return [name for name in PAST[place] if PUBLIC.get(name) == place[1]]


@pytest.mark.parametrize("place", PAST, ids=lambda place: as_line(*place))
def test_public_names_are_imported_as_such(place):
    path, module = place
    names = ", ".join(public_among(place))
    core = f"{'.' * path.count('/')}crosscheck"
    assert not names, f"{path}: write `from {core} import {names}`, not from {module}"


def test_no_import_goes_past_the_public_names_that_is_not_listed():
    """Use a public name instead; what several others need may be made public."""
    new = {
        place: names
        for place, names in PAST.items()
        if as_line(*place) not in LISTED and names != public_among(place)
    }
    lines = [
        f"{path} imports {', '.join(names)} from {module}" for (path, module), names in new.items()
    ]
    instead = f"use public names of {CORE} instead: {', '.join(crosscheck.__all__)}"
    assert not new, "\n".join([*lines, instead])


def test_a_line_that_is_no_longer_needed_is_removed():
    needed = {as_line(*place) for place in PAST}
    unused = [line for line in LISTED if line not in needed]
    assert not unused, "\n".join(f"{LIST.name}: remove this line: {line}" for line in unused)


def test_public_names_are_in_all_lists_of_the_core():
    assert sorted(crosscheck.__all__) == sorted(PUBLIC)
    assert set(crosscheck.__all__) == set(dir(crosscheck))
    assert crosscheck._MODULES == PUBLIC
    for name in crosscheck.__all__:
        assert f"`{name}`" in crosscheck.__doc__
        assert getattr(crosscheck, name) is not None
    # the attribute of this name would be the folder or file as soon as that is loaded
    inside = {path.stem for path in (ROOT / "studies" / "crosscheck").iterdir()}
    assert not inside & set(crosscheck.__all__)


def test_an_unknown_name_is_refused():
    with pytest.raises(AttributeError, match=r"crosscheck.*no attribute 'Scenes'"):
        _ = crosscheck.Scenes


def test_names_of_ringwear_come_from_the_public_names_of_the_core():
    import ringwear

    modules = {
        name: module
        for name, module in ringwear._MODULES.items()
        if is_in_core(module.replace(".", "/"))
    }
    assert set(modules.values()) == {CORE}
    assert importlib.import_module(f"ringwear.{CORE}") is crosscheck


def test_the_core_loads_nothing_before_its_first_use():
    code = (
        "import sys, ringwear.studies.crosscheck as core\n"
        "rooms = [name for name in sys.modules if name.startswith(core.__name__ + '.')]\n"
        "assert not rooms and not {'numpy', 'scipy', 'pydantic', 'xarray'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
