"""Tools and applications import public names of the core, which its rooms list in stubs.

The core is `meshes`, `mdr`, `fem` and `studies/crosscheck`.
"""

import importlib
import re
import subprocess
import sys

import pytest
from test_structure import PUBLIC, PUBLIC_ROOMS, ROOT, imports_in, public_names

# imports that go past public names, with the reason
EXCEPTIONS: dict[tuple[str, str], str] = {}
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
    for module, name in imports_in(file):
        full = f"{module}.{name}".removeprefix("ringwear.")
        is_module = name not in PUBLIC.get(module, {}) and path_of(full)
        yield (full if is_module else full.rpartition(".")[0]), name


def imports_past_public_names():
    """Return files of applications, and modules of the core, with the names that they import."""
    past = {}
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            path = file.relative_to(ROOT).as_posix()
            if is_in_core(path):
                continue
            for module, name in imports_of(file):
                is_public = name in PUBLIC.get(module, {})
                if not is_public and path_of(module) and is_in_core(path_of(module)):
                    past.setdefault((path, module), []).append(name)
    return past


PAST = imports_past_public_names()


def test_no_import_goes_past_the_public_names_without_a_reason():
    """Use a public name instead; what others need may be made public."""
    assert PAST.keys() == EXCEPTIONS.keys()
    assert len(EXCEPTIONS) <= 10


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
