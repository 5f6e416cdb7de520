"""What the commands take: flags and arguments, as `argparse` is told of them."""

import os
import re
from argparse import ArgumentParser, ArgumentTypeError
from pathlib import Path
from typing import Any, NoReturn

from .scene.explain import nearest
from .scene.sources import bundled

# arguments of `add_argument`, by their names
Told = dict[str, Any]


def _directory(text: str) -> Path:
    if not text.strip():
        raise ArgumentTypeError("is empty: give a directory")
    return Path(text)


def _sizes(text: str) -> list[float]:
    try:
        return [float(size) for size in text.split(",")]
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: give numbers, such as 0.2,0.1,0.05") from None


def _positive(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not number > 0:
        raise ArgumentTypeError(f"{text!r}: give a positive number")
    return number


def _relative(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: give a number, such as 1e-4") from None


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: give a whole number") from None


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
    "--no-figures": "write numbers only: neither figures nor the page",
    "--no-report": "write figures, but not the page (report.html)",
    "--verbose": "print everything: each ring, every difference, the cost, what is modelled and "
    "left out",
    "--csv": "write the results as CSV tables, too",
    "--check": "also condense the finite elements, and report how stable their multipliers are",
    "--refinement": "take the files as one program's, from coarse to fine, each half as coarse as "
    "the one before",
    "--quick": "conduct a smaller version of the study; it says first how long that takes",
    "--dry-run": "only say what the sweep will take",
    "--resume": "continue the sweep that is in the directory",
    "--retry-failed": "continue like --resume, and try again the scenes that failed",
}
ARGUMENTS: dict[str, Told] = {
    **{flag: {"action": "store_true", "help": help} for flag, help in FLAGS.items()},
    "scene": {"help": "a TOML file, or the name of a bundled scene"},
    "name": {"nargs": "?", "help": "the name of a bundled scene, to print it"},
    "A": {
        "help": "a folder that `ringwear run` has written, a TOML file, or the name of a bundled "
        "scene"
    },
    "B": {"help": "another one, which is compared with A"},
    "file": {
        "help": "a sweep file (described in studies/sweep/README.md), or the name of a bundled "
        "sweep"
    },
    "files": {
        "nargs": "*",
        "metavar": "FILE",
        "help": "CSV (columns time, radius, pressure, displacement, profile, or time, indentation, "
        "normal_force), netCDF, or VTU of a half-space, of another program",
    },
    "words": {
        "nargs": "*",
        "metavar": "[NAME] FILE",
        "help": "the problem (its name or number; that in the file's name if not given) and a file "
        "as `ringwear check` reads it; NAME alone prints the problem, nothing lists all",
    },
    "--for": {
        "dest": "program",
        "required": True,
        "choices": ("calculix", "abaqus"),
        "help": "the program",
    },
    "--elements": {
        "choices": ("linear", "quadratic"),
        "default": "quadratic",
        "help": "CAX4 or CAX8 in the deck of prescribed displacements; contact is linear "
        "(default: quadratic)",
    },
    "--size": {
        "type": float,
        "metavar": "H",
        "default": 0.1,
        "help": "size of the elements below the punch, in punch radii; they are smaller at ring "
        "edges and at the rim (default: 0.1)",
    },
    "--reach": {
        "type": float,
        "metavar": "R",
        "default": 200.0,
        "help": "radius of the half-space that is modelled, in punch radii (default: 200)",
    },
    "--time": {
        "type": float,
        "action": "append",
        "dest": "times",
        "metavar": "T",
        "help": "a time of a worn face, in the units of the scene; may be repeated (default: the "
        "last time of the scene); the start is always written",
    },
    "--within": {
        "type": _positive,
        "metavar": "X",
        "default": 0.01,
        "help": "relative error that theirs may have, in the norm of each quantity (default: 0.01)",
    },
    "--columns": {
        "type": _pairs,
        "metavar": "THEIRS=OURS,...",
        "help": "names of their columns, each with the name of ours",
    },
    "--sizes": {
        "type": _sizes,
        "metavar": "H,...",
        "help": "sizes of elements or steps, if the files are one program's, from coarse to fine",
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
        "metavar": "DIR",
        "help": "the directory to write to (default: results/NAME, NAME being that of the scene, "
        "study or file)",
    },
    "--rtol": {
        "type": _relative,
        "metavar": "X",
        "help": "the relative accuracy that is wanted, in place of the scene's",
    },
    "--methods": {
        "metavar": "A,B",
        "help": "methods in place of the scene's, separated by commas: mdr, bem, fem, direct, "
        "mdr-grid",
    },
    "--quantities": {
        "metavar": "A,B",
        "help": "quantities, separated by commas, or history, fields, steady or all: only "
        "these are "
        "computed and judged, to the accuracy that is asked for",
    },
    "--memory": {
        "type": _positive,
        "metavar": "GIB",
        "help": "the most memory to use, in GiB: what would need more is refused before it starts "
        "(default: what the machine has)",
    },
    "--scheduler": {
        "metavar": "ADDRESS",
        "help": "the address of a Dask scheduler, to compute on its workers",
    },
    "--workers": {
        "type": _whole,
        "metavar": "N",
        "default": os.cpu_count() or 1,
        "help": "the number of processes on this machine (default: as many as it has cores)",
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
        {"type": _whole, "metavar": "K", "help": "degree of the finite elements on your meshes"},
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


class Parser(ArgumentParser):
    """A parser that asks, of a command or an option that is not there, if the nearest is meant."""

    def error(self, message: str) -> NoReturn:
        """Print how the command is used and what is wrong, and exit with status 2."""
        flags = [*(name for name in ARGUMENTS if name.startswith("--"))]
        flags += [flag for flag, _ in OF_STUDIES.values()]
        near = ""
        if choice := re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message):
            near = nearest(choice[1], re.findall(r"[\w-]+", choice[2]))
            if choice[1] in bundled() or choice[1].endswith(".toml"):
                near = f"ringwear run {choice[1]}"
        elif unknown := re.search(r"unrecognized arguments: (--[\w-]+)", message):
            # without dashes, which all have
            bare = {re.sub(r"\W", "", flag): flag for flag in flags}
            near = bare.get(nearest(re.sub(r"\W", "", unknown[1]), bare), "")
        super().error(f"{message}; did you mean {near}?" if near else message)
