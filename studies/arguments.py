"""What the commands take: flags and arguments, as `argparse` is told of them."""

import os
from argparse import ArgumentTypeError
from pathlib import Path
from typing import Any

# arguments of `add_argument`, by their names
Told = dict[str, Any]


def _directory(text: str) -> Path:
    if not text.strip():
        raise ArgumentTypeError("is empty: give a directory")
    return Path(text)


def _sizes(text: str) -> list[float]:
    return [float(size) for size in text.split(",")]


def _pairs(text: str) -> dict[str, str]:
    pairs = dict(pair.partition("=")[::2] for pair in text.split(","))
    if not all(name and ours for name, ours in pairs.items()):
        raise ArgumentTypeError(f"{text!r}: give theirs=ours, such as p=pressure,r=radius")
    return pairs


def _name_of_file(text: str) -> str:
    if not text.strip():
        raise ArgumentTypeError("is empty: give a file")
    return text


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(","))


def _steps(text: str) -> tuple[float, ...]:
    return tuple(_sizes(text))


FLAGS = {
    "--no-figures": "numbers only: neither figures nor the report",
    "--no-report": "figures, but no report.html",
    "--verbose": "say all: rings, every difference, cost, what is modelled and what is left out",
    "--csv": "the results as CSV tables, too",
    "--check": "also condense it, and report the stability of the multipliers",
    "--quick": "a smaller version of the study",
    "--dry-run": "say what it will take, without computing",
    "--resume": "go on with what is in the directory",
    "--retry-failed": "as --resume, and try again the scenes that failed",
}
ARGUMENTS: dict[str, Told] = {
    **{flag: {"action": "store_true", "help": help} for flag, help in FLAGS.items()},
    "scene": {"help": "a TOML file or a bundled scene"},
    "name": {"nargs": "?", "help": "a bundled scene, to start one of your own from"},
    "A": {"help": "a folder of `ringwear run`, a TOML file or a bundled scene"},
    "B": {"help": "another one"},
    "file": {"help": "a sweep file (studies/sweep/README.md), or a bundled sweep"},
    "files": {
        "nargs": "*",
        "metavar": "FILE",
        "help": "CSV (columns time, radius, pressure, displacement, profile, or time, indentation, "
        "normal_force), netCDF, or VTU of a half-space, of another program",
    },
    "--within": {
        "type": float,
        "default": 0.01,
        "help": "relative error that theirs may have, in the norm of each quantity (default: 0.01)",
    },
    "--columns": {"type": _pairs, "metavar": "THEIRS=OURS,...", "help": "names of their columns"},
    "--sizes": {
        "type": _sizes,
        "metavar": "H,...",
        "help": "of elements or steps, where several files are a refinement from coarse to fine "
        "(default: each half of the one before)",
    },
    "--template": {
        "type": _directory,
        "metavar": "DIR",
        "help": "write what another program has to model and to sample: a table, a mesh, "
        "and the scene in words",
    },
    "--units": {
        "default": "",
        "help": "units of theirs, such as 'mm, N, MPa, s' (default: those of the scene)",
    },
    "--out": {
        "type": _directory,
        "help": "directory (default: results/ and the name of scene, study or file)",
    },
    "--rtol": {"type": float, "help": "relative accuracy, in place of the scene's"},
    "--methods": {"help": "methods, comma-separated, in place of the scene's"},
    "--quantities": {
        "help": "quantities, or history, fields, steady or all, comma-separated: only these are "
        "computed and judged, to the accuracy asked for"
    },
    "--memory": {
        "type": float,
        "metavar": "GIB",
        "help": "most memory in GiB; what would need more is refused before it starts (default: "
        "what the machine has)",
    },
    "--scheduler": {"metavar": "ADDRESS", "help": "a Dask scheduler, to compute on its workers"},
    "--workers": {
        "type": int,
        "default": os.cpu_count() or 1,
        "help": "processes on this machine (default: its cores)",
    },
}
OF_STUDIES: dict[str, tuple[str, Told]] = {
    "meshes": (
        "--mesh",
        {
            "action": "append",
            "default": [],
            "type": _name_of_file,
            "metavar": "FILE",
            "help": "a mesh file of yours: .msh of gmsh, .vtu, ...; repeated, from coarse to fine",
        },
    ),
    "degree": (
        "--degree",
        {"type": int, "metavar": "K", "help": "degree of the finite elements on your meshes"},
    ),
    "quantities": (
        "--quantity",
        {
            "action": "append",
            "default": [],
            "metavar": "FILE.py:NAME",
            "help": "a function of yours that takes a result of a run and returns a number; may be "
            "repeated",
        },
    ),
    "elements": (
        "--element",
        {
            "action": "append",
            "default": [],
            "metavar": "NAME",
            "help": "an element of scikit-fem, such as ElementTriP2, or FILE.py:NAME; may be "
            "repeated",
        },
    ),
    "methods": (
        "--methods",
        {"type": _names, "default": (), "help": "methods, comma-separated, in place of all"},
    ),
    "steps": (
        "--steps",
        {
            "type": _steps,
            "default": (),
            "metavar": "H,...",
            "help": "steps in time, from coarse to fine, in the units of the scene",
        },
    ),
    "against": (
        "--against",
        {
            "choices": ("size", "unknowns", "seconds"),
            "default": "size",
            "help": "what figures draw errors against (default: size)",
        },
    ),
}
"""Options of studies by the name of the option: the flag, and what `argparse` is told of it."""
