"""What the commands take: flags and arguments, as `argparse` is told of them."""

import os
from argparse import ArgumentParser, ArgumentTypeError
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


def _noise(text: str) -> str | dict[str, str]:
    return _pairs(text) if "=" in text else text


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
    "--design": "also say which further measurement would narrow the widest interval most",
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
    "data": {
        "nargs": "+",
        "metavar": "DATA",
        "help": "measurements: CSV with columns time, indentation, normal_force; time, radius, "
        "profile; worn_volume or lost_mass, worn_volume_1 that of the first ring from the centre",
    },
    "--for": {
        "type": _names,
        "required": True,
        "metavar": "NAME,...",
        "dest": "parameters",
        "help": "what is unknown: keys of the scene, such as punch.wear_coefficients (each of "
        "them) or punch.wear_coefficients[1], or start_time, sensor_offset, machine_compliance",
    },
    "--noise": {
        "type": _noise,
        "metavar": "X",
        "help": "standard deviation of the data, such as 2e-7, '0.2 um', '1 %%' of each value, or "
        "indentation=2e-7,profile=1e-6 (default: from the residuals)",
    },
    "--density": {"help": "of the punch, if mass was lost, such as '7.8 g/cm^3'"},
    "--within": {
        "type": float,
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
        "help": "the directory to write to (default: results/NAME, NAME being that of the scene, "
        "study or file)",
    },
    "--rtol": {
        "type": float,
        "help": "the relative accuracy that is wanted, in place of the scene's",
    },
    "--methods": {
        "help": "methods in place of the scene's, separated by commas: mdr, bem, fem, direct, "
        "mdr-grid"
    },
    "--quantities": {
        "help": "quantities, separated by commas, or history, fields, steady or all: only "
        "these are "
        "computed and judged, to the accuracy that is asked for"
    },
    "--memory": {
        "type": float,
        "metavar": "GIB",
        "help": "the most memory to use, in GiB: what would need more is refused before it starts "
        "(default: what the machine has)",
    },
    "--scheduler": {
        "metavar": "ADDRESS",
        "help": "the address of a Dask scheduler, to compute on its workers",
    },
    "--workers": {
        "type": int,
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


EXAMPLES = """examples:
  ringwear run                             compute the bundled scene five_rings
  ringwear scenes sphere > mine.toml       start a scene of your own from a bundled one
  ringwear run mine.toml --rtol 1e-3       compute it to another accuracy
  ringwear check mine.toml abaqus.csv      compare results of another program with ours
  ringwear fit mine.toml data.csv --for punch.wear_coefficient
                                           find a wear coefficient from measurements
  ringwear study convergence --quick       see the orders of convergence beside theory
"""


def add_arguments(parser: ArgumentParser, names: tuple[str, ...], scene: str | None) -> None:
    """Add arguments to a command; the scene may be left out where there is one by default."""
    for name in names:
        settings = ARGUMENTS[name]
        if name == "scene" and scene:
            help = f"{settings['help']} (default: {scene})"
            settings = {"nargs": "?", "default": scene, "help": help}
        parser.add_argument(name, **settings)
