"""Versions of ringwear and of what it computes with: results carry them."""

import json
from functools import cache
from hashlib import blake2b
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from pathlib import Path

NAMES = ("ringwear", "numpy", "scipy", "scikit-fem", "gmsh", "kvxopt", "meshio", "xarray")
# everything but the public names, which stand elsewhere in a plain checkout
PARTS = ("meshes", "mdr", "fem", "studies")
# of code and data tables
SUFFIXES = (".py", ".json", ".toml")


def versions() -> dict[str, str]:
    """Versions of ringwear and of what it computes with."""
    known = {}
    for name in NAMES:
        try:
            known[name] = version(name)
        except PackageNotFoundError:
            known[name] = "not installed"
    return known


@cache
def fingerprint() -> str:
    """Return versions and a hash of ringwear's code and tables, as JSON."""
    code = blake2b(digest_size=16)
    for part in PARTS:
        folder = Path(str(files(f"ringwear.{part}")))
        for file in sorted(folder.rglob("*")):
            name = file.relative_to(folder)
            if file.suffix in SUFFIXES and name.parts[0] != "api":
                code.update(f"{part}/{name.as_posix()}\0".encode() + file.read_bytes())
    return json.dumps(versions() | {"code": code.hexdigest()})


def differing(other: str) -> str:
    """Return what is another in a fingerprint than here."""
    here, there = json.loads(fingerprint()), json.loads(other or "{}")
    return ", ".join(name for name in here if there.get(name) != here[name])
