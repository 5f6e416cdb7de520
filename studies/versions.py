"""Versions of ringwear and of what it computes with: results carry them."""

import json
from functools import cache
from hashlib import blake2b
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from pathlib import Path


@cache
def versions() -> dict[str, str]:
    """Versions of ringwear and of what it computes with."""
    names = ("ringwear", "numpy", "scipy", "scikit-fem", "gmsh", "kvxopt", "meshio", "xarray")
    known = {}
    for name in names:
        try:
            known[name] = version(name)
        except PackageNotFoundError:
            known[name] = "not installed"
    return known


@cache
def fingerprint() -> str:
    """Return versions and a hash of ringwear's code and tables, as JSON."""
    # of code and data tables
    suffixes = (".py", ".json", ".toml")
    # everything but the public names, which stand elsewhere in a plain checkout
    parts = ("meshes", "mdr", "fem", "studies")
    code = blake2b(digest_size=16)
    for part in parts:
        folder = Path(str(files(f"ringwear.{part}")))
        for file in sorted(folder.rglob("*")):
            name = file.relative_to(folder)
            if file.suffix in suffixes and name.parts[0] != "api":
                code.update(f"{part}/{name.as_posix()}\0".encode() + file.read_bytes())
    return json.dumps(versions() | {"code": code.hexdigest()})


def differing(other: str) -> str:
    """Return what is another in a fingerprint than here."""
    here, there = json.loads(fingerprint()), json.loads(other or "{}")
    return ", ".join(name for name in here if there.get(name) != here[name])
