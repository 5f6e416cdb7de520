"""Define flags and arguments of all commands for `argparse`."""

import os
import re
from argparse import ArgumentParser, ArgumentTypeError
from pathlib import Path
from typing import Any, NoReturn

from .crosscheck.scene.explain import nearest
from .crosscheck.scene.sources import bundled

# keyword arguments of `ArgumentParser.add_argument`
Settings = dict[str, Any]


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


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: give a number, such as 0.5") from None


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


def _noise(text: str) -> str | dict[str, str]:
    return _pairs(text) if "=" in text else text


def _steps(text: str) -> tuple[float, ...]:
    return tuple(_sizes(text))


FLAGS = {
    "--no-figures": "write numbers only, no figures and no page",
    "--no-report": "write figures, but not the page (report.html)",
    "--verbose": "print everything: each ring, every difference, the cost, what is modelled and "
    "left out",
    "--csv": "write the results as CSV tables, too",
    "--check": "also condense the finite elements, and report how stable their multipliers are",
    "--refinement": "treat the files as results of one program from coarse to fine, each with half "
    "the size of the previous one",
    "--design": "also print which further measurement would narrow the widest interval most",
    "--quick": "conduct a smaller version of the study, and print first how long it takes",
    "--latex": "print the table in LaTeX instead of Markdown",
    "--dry-run": "only print what the sweep will need",
    "--resume": "continue the sweep or the study in the directory",
    "--retry-failed": "continue like --resume, and compute scenes that failed again",
}
ARGUMENTS: dict[str, Settings] = {
    **{flag: {"action": "store_true", "help": help} for flag, help in FLAGS.items()},
    "scene": {"help": "a TOML file, or the name of a bundled scene"},
    "name": {"nargs": "?", "help": "the name of a bundled scene, to print it"},
    "A": {
        "help": "a folder that `ringwear run` has written, a TOML file, or the name of a bundled "
        "scene"
    },
    "B": {"help": "the same, to be compared with A"},
    "file": {
        "help": "a sweep file (described in studies/sweep/README.md), or the name of a bundled "
        "sweep"
    },
    "files": {
        "nargs": "*",
        "metavar": "FILE",
        "help": "results of another program: CSV (columns time, radius, pressure, displacement, "
        "profile, or time, indentation, normal_force), netCDF, or VTU of a half-space",
    },
    "table": {
        "metavar": "TABLE",
        "help": "a CSV file with one row for each level and one column for each quantity; with a "
        "column radius, the other columns are fields; or the table of a study",
    },
    "--by": {
        "required": True,
        "metavar": "COLUMN",
        "help": "the column with the size of each level, such as the element size",
    },
    "--right": {
        "action": "append",
        "default": [],
        "metavar": "[NAME=]VALUE",
        "help": "the right value of a column, or of all columns; 0 for errors; may be repeated",
    },
    "--tolerance": {
        "type": _positive,
        "metavar": "X",
        "help": "greatest relative error of the finest level; exit status 3 if one is greater",
    },
    "words": {
        "nargs": "*",
        "metavar": "[NAME] FILE",
        "help": "the problem (its name or number; by default the number in the file's name) and a "
        "file for `ringwear check`; NAME alone prints the problem, no argument lists all problems",
    },
    "--for PROGRAM": {
        "dest": "program",
        "required": True,
        "type": str.lower,
        "choices": ("calculix", "abaqus"),
        "help": "the program",
    },
    "--elements": {
        "choices": ("linear", "quadratic"),
        "default": "quadratic",
        "help": "CAX4 or CAX8 in the deck of prescribed displacements; contact is linear "
        "(default: quadratic)",
    },
    "data": {
        "nargs": "+",
        "metavar": "DATA",
        "help": "measurements: CSV with columns time, indentation, normal_force; time, radius, "
        "profile; worn_volume or lost_mass; worn_volume_1 for the first ring from the centre",
    },
    "--for": {
        "type": _names,
        "required": True,
        "metavar": "NAME,...",
        "dest": "parameters",
        "help": "unknown parameters: keys of the scene, such as punch.wear_coefficients (all of "
        "them) or punch.wear_coefficients[1], or start_time, sensor_offset, machine_compliance",
    },
    "--noise": {
        "type": _noise,
        "metavar": "X",
        "help": "standard deviation of the data, such as 2e-7, '0.2 um', '1 %%' of each value, or "
        "indentation=2e-7,profile=1e-6 (default: from the residuals)",
    },
    "--density": {"help": "density of the punch for data on lost mass, such as '7.8 g/cm^3'"},
    "--size": {
        "type": _number,
        "metavar": "H",
        "default": 0.1,
        "help": "size of the elements below the punch, in punch radii; they are smaller at ring "
        "edges and at the rim (default: 0.1)",
    },
    "--reach": {
        "type": _number,
        "metavar": "R",
        "default": 200.0,
        "help": "radius of the half-space that is modelled, in punch radii (default: 200)",
    },
    "--time": {
        "type": _number,
        "action": "append",
        "dest": "times",
        "metavar": "T",
        "help": "a time for a deck of the worn face, in the units of the scene; may be repeated "
        "(default: the last time of the scene with a load); the first such time always has a deck",
    },
    "--within": {
        "type": _positive,
        "metavar": "X",
        "default": 0.01,
        "help": "allowed relative error of their results in the norm of each quantity "
        "(default: 0.01)",
    },
    "--columns": {
        "type": _pairs,
        "metavar": "THEIRS=OURS,...",
        "help": "names of their columns, each with the name of the quantity in ringwear",
    },
    "--sizes": {
        "type": _sizes,
        "metavar": "H,...",
        "help": "sizes of elements or steps, from coarse to fine, if all files are results of one "
        "program",
    },
    "--template": {
        "type": _directory,
        "metavar": "DIR",
        "help": "write files for another program: the table to fill in, a mesh, and the scene in "
        "words",
    },
    "--units": {
        "default": "",
        "help": "units of their results, such as 'mm, N, MPa, s' (default: those of the scene)",
    },
    "--out": {
        "type": _directory,
        "metavar": "DIR",
        "help": "the directory to write to (default: results/NAME with the name of the scene, "
        "study or file)",
    },
    "--rtol": {
        "type": _relative,
        "metavar": "X",
        "help": "relative tolerance, instead of the scene's",
    },
    "--methods": {
        "metavar": "A,B",
        "help": "methods, separated by commas, instead of the scene's: mdr, bem, fem, direct, "
        "mdr-grid",
    },
    "--quantities": {
        "metavar": "A,B",
        "help": "quantities, separated by commas, or history, fields, steady or all: only these "
        "are computed to the tolerance and judged",
    },
    "--memory": {
        "type": _positive,
        "metavar": "GIB",
        "help": "largest memory to use, in GiB; a run that needs more is refused before it starts "
        "(default: the memory of the machine)",
    },
    "--scheduler": {
        "metavar": "ADDRESS",
        "help": "the address of a Dask scheduler, to compute on its workers",
    },
    "--workers": {
        "type": _whole,
        "metavar": "N",
        "default": os.cpu_count() or 1,
        "help": "the number of processes on this machine (default: the number of its cores)",
    },
}
OF_STUDIES: dict[str, tuple[tuple[str, Settings], ...]] = {
    "meshes": (
        (
            "--mesh",
            {
                "action": "append",
                "type": _name_of_file,
                "metavar": "FILE",
                "help": "a mesh file of your own (.msh of gmsh, .vtu, ...); repeat it from coarse "
                "to fine",
            },
        ),
    ),
    "degree": (
        (
            "--degree",
            {
                "type": _whole,
                "metavar": "K",
                "help": "degree of the finite elements on your meshes",
            },
        ),
    ),
    "quantities": (
        (
            "--quantities",
            {
                "action": "extend",
                "type": _names,
                "metavar": "A,B",
                "help": "names of the quantities to tabulate and draw, separated by commas",
            },
        ),
        (
            "--quantity",
            {
                "action": "append",
                "metavar": "FILE.py:NAME",
                "help": "a function of your own that takes the result of a run and returns a "
                "number; may be repeated",
            },
        ),
    ),
    "elements": (
        (
            "--element",
            {
                "action": "append",
                "metavar": "NAME",
                "help": "an element of scikit-fem, such as ElementTriP2, or FILE.py:NAME; may be "
                "repeated",
            },
        ),
    ),
    "methods": (
        (
            "--methods",
            {
                "type": _names,
                "metavar": "A,B",
                "help": "methods, separated by commas, instead of the study's own selection; "
                "FILE.py:NAME is a method of your own",
            },
        ),
    ),
    "steps": (
        (
            "--steps",
            {
                "type": _steps,
                "metavar": "H,...",
                "help": "steps in time, from coarse to fine, in the units of the scene",
            },
        ),
    ),
    "radii": (
        (
            "--radii",
            {
                "type": _steps,
                "metavar": "R,...",
                "help": "truncation radii in punch radii, increasing",
            },
        ),
    ),
    "vary": (
        (
            "--vary",
            {
                "action": "append",
                "metavar": "KEY=[geom:]LOW:HIGH:N",
                "help": "a key of the scene and its values: N from LOW to HIGH, equally spaced or "
                "by equal factors (geom); may be repeated",
            },
        ),
    ),
    "against": (
        (
            "--against",
            {
                "choices": ("size", "unknowns", "seconds"),
                "help": "what figures draw errors against (default: size)",
            },
        ),
    ),
}
"""Options of studies by their names: flags, and their settings for `argparse`."""


OTHER_COMMANDS = {
    **dict.fromkeys(("solve", "simulate", "compute", "calculate", "start"), "ringwear run"),
    **dict.fromkeys(("list", "ls", "examples", "show"), "ringwear scenes"),
    **dict.fromkeys(("init", "new", "create"), "ringwear scenes five_rings > mine.toml"),
    **dict.fromkeys(("validate", "verify", "estimate"), "ringwear plan"),
    **dict.fromkeys(("template", "export"), "ringwear check SCENE --template DIR"),
    **dict.fromkeys(("plot", "report"), "ringwear run, which draws figures and writes a page"),
    "diff": "ringwear compare",
    "help": "ringwear --help",
    "version": "ringwear --version",
}
"""Commands by other names that users may write."""
OTHER_FLAGS = {
    **dict.fromkeys(("-o", "--output", "--folder", "--directory", "--dir"), "--out"),
    **dict.fromkeys(("--tol", "--tolerance", "--accuracy"), "--rtol"),
    **dict.fromkeys(("--method", "--solver", "-m"), "--methods"),
    **dict.fromkeys(("-v", "--version"), "--verbose"),
    **dict.fromkeys(("-j", "--jobs", "--threads", "--processes"), "--workers"),
}
"""Options by other names that users may write."""


class Parser(ArgumentParser):
    """A parser that suggests the nearest name for an unknown command or option."""

    def error(self, message: str) -> NoReturn:
        """Print the usage of the command and the error, and exit with status 2."""
        flags = [*(name for name in ARGUMENTS if name.startswith("--"))]
        flags += [flag for listed in OF_STUDIES.values() for flag, _ in listed]
        suggestion = ""
        if choice := re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message):
            suggestion = OTHER_COMMANDS.get(choice[1], "") if "COMMAND" in message else ""
            suggestion = suggestion or nearest(choice[1], re.findall(r"[\w-]+", choice[2]))
            if choice[1] in bundled() or choice[1].endswith(".toml"):
                suggestion = f"ringwear run {choice[1]}"
        elif unknown := re.search(r"unrecognized arguments: (-[\w-]+)", message):
            # compare without dashes, which are common to all flags
            flags_without_dashes = {re.sub(r"\W", "", flag): flag for flag in flags}
            suggestion = OTHER_FLAGS.get(unknown[1], "") or flags_without_dashes.get(
                nearest(re.sub(r"\W", "", unknown[1]), flags_without_dashes), ""
            )
            if suggestion == unknown[1]:
                # an option of another command
                super().error(f"{message}; this command does not have it: --help lists its options")
        if message.startswith("unrecognized arguments") and not suggestion:
            super().error(f"{message}; leave it out: --help lists what the command takes")
        super().error(f"{message}; did you mean {suggestion}?" if suggestion else message)


EXAMPLES = """examples:
  ringwear run                          compute the scene five_rings
  ringwear scenes sphere > mine.toml    start a scene of your own
  ringwear run mine.toml --rtol 1e-3    compute it with another tolerance
  ringwear deck mine.toml --for abaqus  write input files for another program
  ringwear check mine.toml abaqus.csv   check another program's results
  ringwear fit mine.toml data.csv --for punch.wear_coefficient
                                        fit wear coefficients to measurements
  ringwear study convergence --quick    compare orders with theory
"""


def add_arguments(parser: ArgumentParser, names: tuple[str, ...], scene: str | None) -> None:
    """Add arguments to a command; the scene is optional if the command has a default scene."""
    for name in names:
        settings = ARGUMENTS[name]
        if name == "scene" and scene:
            help = f"{settings['help']} (default: {scene})"
            settings = {"nargs": "?", "default": scene, "help": help}
        # "--for" and "--for PROGRAM" are the same flag of two commands
        parser.add_argument(name.split()[0], **settings)
