"""Versions of ringwear and of what it computes with, and a hash of its own files.

Results carry the versions; sweeps, which several processes compute at several times, both.
"""

import hashlib
import json
import sys
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from . import STARTED

# parts of the package whose files are hashed
PACKAGES = ("meshes", "mdr", "fem", "studies")


@cache
def versions() -> dict[str, str]:
    """Return the versions of ringwear and of what it computes with."""
    names = ("ringwear", "numpy", "scipy", "scikit-fem", "gmsh", "kvxopt", "meshio", "xarray")
    installed = {}
    for name in names:
        try:
            installed[name] = version(name)
        except PackageNotFoundError:
            installed[name] = "not installed"
    return installed


def computed_with() -> dict[str, str]:
    """Return the versions, and the hash of ringwear's files as this process has loaded them."""
    return versions() | {"code": code()}


def code() -> str:
    """Return a hash of ringwear's files, as this process has loaded them.

    Files are read at the first call, and those that Python loads later once more when they are
    loaded. What is edited after that does not change the hash, as it does not change the process.
    A file that was edited between the start and the first call may be loaded as it was before: it
    counts as one that nobody else has.
    """
    files, modules = _files(), _loaded_modules()
    if later := modules - _noted:
        _noted.update(later)
        changed = {file: _digest(file) for file in _files_of(later) & files.keys()}
        files |= {file: (files[file][0], digest) for file, digest in changed.items()}
        _hash.cache_clear()
    return _hash()


@cache
def _hash() -> str:
    told = sorted(f"{name} {digest}" for name, digest in _files().values())
    return hashlib.sha256("\n".join(told).encode()).hexdigest()[:16]


def stamp() -> int:
    """Return a whole number of 64 bits for all that results are computed with."""
    told = json.dumps(computed_with(), sort_keys=True).encode()
    return int.from_bytes(hashlib.sha256(told).digest()[:8], "big")


@cache
def _files() -> dict[Path, tuple[str, str]]:
    """Return the name within the package and a hash of each of its files."""
    files, modules = dict[Path, tuple[str, str]](), _loaded_modules()
    loaded = _files_of(modules)
    for package in PACKAGES:
        spec = find_spec(f"ringwear.{package}")
        (folder,) = spec.submodule_search_locations or [""] if spec else [""]
        for file in sorted(Path(folder).rglob("*.py")):
            name = f"{package}/{file.relative_to(folder).as_posix()}"
            # the front of the package is another folder where it is installed
            if not name.startswith("studies/api/"):
                changed = file.stat().st_ctime_ns
                edited = file in loaded and changed > STARTED
                files[file] = name, f"edited, {changed}" if edited else _digest(file)
    _noted.update(modules)
    return files


_noted = set[str]()
"""Modules whose files have been hashed as they were loaded."""


def _loaded_modules() -> set[str]:
    return {name for name in list(sys.modules) if name.startswith("ringwear.")}


def _files_of(modules: set[str]) -> set[Path]:
    loaded = (getattr(sys.modules.get(name), "__file__", None) for name in modules)
    return {Path(file) for file in loaded if file}


def _digest(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return "gone"
