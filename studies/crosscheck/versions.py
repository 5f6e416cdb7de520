"""Versions of ringwear and of its dependencies, and a hash of ringwear's files.

Results contain the versions. Sweeps, which several processes may compute at different times, also
contain the hash.
"""

import hashlib
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from .. import STARTED

# parts of the package whose files are hashed
PACKAGES = ("meshes", "mdr", "fem", "studies")


@cache
def package_versions() -> dict[str, str]:
    """Return the versions of ringwear and of its dependencies."""
    # it takes longer to load than the help of the command line
    from importlib.metadata import PackageNotFoundError, version

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
    return package_versions() | {"code": code()}


def code() -> str:
    """Return a hash of ringwear's files, as this process has loaded them.

    Files are read at the first call. A file that Python loads later is read again at the next call
    after that. Later edits change neither the process nor the hash. If a file was edited between
    the start and the first call, it is unknown which version was loaded; such a file counts as
    different from all other versions.
    """
    files, modules = _files(), _loaded_modules()
    if new_modules := modules - _hashed_modules:
        _hashed_modules.update(new_modules)
        changed = {file: _digest(file) for file in _files_of(new_modules) & files.keys()}
        files |= {file: (files[file][0], digest) for file, digest in changed.items()}
        _hash.cache_clear()
    return _hash()


@cache
def _hash() -> str:
    lines = sorted(f"{name} {digest}" for name, digest in _files().values())
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


@cache
def _files() -> dict[Path, tuple[str, str]]:
    """Return the name within the package and a hash of each file, by its path."""
    files, modules = dict[Path, tuple[str, str]](), _loaded_modules()
    loaded = _files_of(modules)
    for package in PACKAGES:
        spec = find_spec(f"ringwear.{package}")
        (folder,) = spec.submodule_search_locations or [""] if spec else [""]
        for file in sorted(Path(folder).rglob("*.py")):
            name = f"{package}/{file.relative_to(folder).as_posix()}"
            # skip the public package, which is a different folder in an installation
            if not name.startswith("studies/api/"):
                changed = file.stat().st_ctime_ns
                edited = file in loaded and changed > STARTED
                files[file] = name, f"edited, {changed}" if edited else _digest(file)
    _hashed_modules.update(modules)
    return files


_hashed_modules = set[str]()
"""Names of loaded modules whose files have been hashed."""


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
