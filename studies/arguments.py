"""The arguments of commands: parameters of functions as flags, and their docstrings as help."""

import re
from argparse import ArgumentParser, ArgumentTypeError, RawDescriptionHelpFormatter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from .crosscheck import bundled, nearest
from .documented import documented

# keyword arguments of `ArgumentParser.add_argument`
Settings = dict[str, Any]


def _directory(text: str) -> Path:
    return Path(_not_empty(text, "directory"))


def _file(text: str) -> str:
    return _not_empty(text, "file")


def _not_empty(text: str, what: str) -> str:
    if not text.strip():
        raise ArgumentTypeError(f"is empty: give a {what}")
    return text


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: give a number, such as 1e-4") from None


def _positive(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not number > 0:
        raise ArgumentTypeError(f"{text!r}: give a positive number")
    return number


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: give a whole number") from None


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(size) for size in text.split(","))
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: give numbers, such as 0.2,0.1,0.05") from None


def _pairs(text: str) -> dict[str, str]:
    pairs = dict(pair.partition("=")[::2] for pair in text.split(","))
    if not all(name and ours for name, ours in pairs.items()):
        raise ArgumentTypeError(f"{text!r}: give theirs=ours, such as p=pressure,r=radius")
    return pairs


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(","))


def _noise(text: str) -> str | dict[str, str]:
    return _pairs(text) if "=" in text else text


FLAGS: dict[str, Settings] = {
    "--against": {"choices": ("size", "unknowns", "seconds")},
    "--by": {"required": True, "metavar": "COLUMN"},
    "--columns": {"type": _pairs, "metavar": "THEIRS=OURS,..."},
    "--degree": {"type": _whole, "metavar": "K"},
    "--density": {"metavar": "X"},
    "--cycle": {"metavar": "LENGTH"},
    "--element": {"metavar": "NAME"},
    "--for": {
        "required": True,
        "type": str.lower,
        "choices": ("calculix", "abaqus"),
    },
    "--memory": {"type": _positive, "metavar": "GIB"},
    "--mesh": {"type": _file, "metavar": "FILE"},
    "--methods": {"type": _names, "metavar": "A,B"},
    "--noise": {"type": _noise, "metavar": "X"},
    "--parameters": {"type": _names, "required": True, "metavar": "NAME,..."},
    "--quantities": {"action": "extend", "type": _names, "metavar": "A,B"},
    "--quick": {"action": "store_true"},
    "--radii": {"type": _numbers, "metavar": "R,..."},
    "--reach": {"type": _number, "metavar": "R"},
    "--resume": {"action": "store_true"},
    "--retry-failed": {"action": "store_true"},
    "--right": {"action": "append", "metavar": "[NAME=]VALUE"},
    "--rtol": {"type": _number, "metavar": "X"},
    "--size": {"type": _number, "metavar": "H"},
    "--sizes": {"type": _numbers, "metavar": "H,..."},
    "--steps": {"type": _numbers, "metavar": "H,..."},
    "--time": {"type": _number, "metavar": "T"},
    "--tolerance": {"type": _positive, "metavar": "X"},
    "--units": {"metavar": "UNITS"},
    "--vary": {"action": "append", "metavar": "KEY=[geom:]LOW:HIGH:N"},
    "--within": {"type": _positive, "metavar": "X"},
    "--workers": {"type": _whole, "metavar": "N"},
}
"""Types of the flags that are parameters of functions; a flag means the same in all commands."""
OTHER_NAMES = {"program": "--for"}
"""Flags of parameters that have other names."""
REPEATED = {"times": "--time", "meshes": "--mesh", "elements": "--element"}
"""Flags that are given once for each entry of a parameter, from which the others are made."""
OF_COMMANDS: dict[str, Settings] = {
    "--out": {
        "type": _directory,
        "metavar": "DIR",
        "help": "the directory to write to (default: results/NAME with the name of the scene, "
        "study or file)",
    },
    "--no-figures": {
        "action": "store_true",
        "help": "write numbers only, no figures and no page",
    },
    "--no-report": {
        "action": "store_true",
        "help": "write figures, but not the page (report.html)",
    },
    "--verbose": {
        "action": "store_true",
        "help": "print everything: each ring, every difference, the cost, what is modelled and "
        "left out",
    },
    "--csv": {"action": "store_true", "help": "write the results as CSV tables, too"},
    "--check": {
        "action": "store_true",
        "help": "also condense the finite elements, and report how stable their multipliers are",
    },
    "--refinement": {
        "action": "store_true",
        "help": "treat the files as results of one program from coarse to fine, each with half the "
        "size of the previous one",
    },
    "--list": {"action": "store_true", "help": "list the problems, as without any argument"},
    "--latex": {"action": "store_true", "help": "print the table in LaTeX instead of Markdown"},
    "--dry-run": {
        "action": "store_true",
        "help": "only print what the sweep will need, by a probe of its first scene",
    },
    "--resume": {"action": "store_true", "help": "continue the study in the directory"},
    "--scheduler": {
        "metavar": "ADDRESS",
        "help": "the address of a Dask scheduler, to compute on its workers",
    },
    "--quantity": {
        "action": "append",
        "dest": "quantities",
        "metavar": "FILE.py:NAME",
        "help": "a function of your own that takes the result of a run and returns a number; may "
        "be repeated",
    },
}
"""Flags of commands that their functions do not have."""
POSITIONAL: dict[str, Settings] = {
    "scene": {"help": "a TOML file, or the name of a bundled scene"},
    "file": {
        "metavar": "FILE",
        "help": "a sweep file (described in studies/sweep/README.md), or the name of a bundled "
        "sweep",
    },
    "name": {
        "nargs": "?",
        "metavar": "NAME",
        "help": "the name of a bundled scene, to print it",
    },
    "a": {
        "metavar": "A",
        "help": "a folder that ringwear run has written, a TOML file, or the name of a bundled "
        "scene",
    },
    "b": {"metavar": "B", "help": "the same, to be compared with A"},
    "theirs": {
        "nargs": "*",
        "metavar": "FILE",
        "help": "results of another program: CSV (columns time, radius, pressure, displacement, "
        "profile, or time, indentation, normal_force), netCDF, or VTU of a half-space",
    },
    "data": {
        "nargs": "+",
        "metavar": "DATA",
        "help": "measurements: CSV with columns time, indentation, normal_force; time, radius, "
        "profile; worn_volume or lost_mass; worn_volume_1 for the first ring from the centre",
    },
    "table": {
        "metavar": "TABLE",
        "help": "a CSV file with one row for each level and one column for each quantity; with a "
        "column radius, the other columns are fields; or the table of a study",
    },
    "words": {
        "nargs": "*",
        "metavar": "[NAME] FILE",
        "help": "the problem (its name or number; by default the number in the file's name) and a "
        "file for ringwear check or, on layered ground, with a table of cases; NAME alone prints "
        "the problem, no argument lists all problems",
    },
}
"""Arguments that have no flag: files where their functions accept other things, too."""


class Parser(ArgumentParser):
    """A parser that suggests the nearest name for an unknown command or option."""

    def error(self, message: str) -> NoReturn:
        """Print the usage of the command and the error, and exit with status 2."""
        suggestion = ""
        if choice := re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message):
            suggestion = nearest(choice[1], re.findall(r"[\w-]+", choice[2]))
            if choice[1] in bundled() or choice[1].endswith(".toml"):
                suggestion = f"ringwear run {choice[1]}"
        elif unknown := re.search(r"unrecognized arguments: (-[\w-]+)", message):
            # compare without dashes, which are common to all flags
            without_dashes = {re.sub(r"\W", "", flag): flag for flag in (*FLAGS, *OF_COMMANDS)}
            near = nearest(re.sub(r"\W", "", unknown[1]), without_dashes)
            suggestion = without_dashes.get(near, "")
            if suggestion == unknown[1]:
                # an option of another command
                super().error(f"{message}; this command does not have it: --help lists its options")
        if message.startswith("unrecognized arguments") and not suggestion:
            super().error(f"{message}; leave it out: --help lists what the command takes")
        super().error(f"{message}; did you mean {suggestion}?" if suggestion else message)


def add_arguments(
    parser: ArgumentParser,
    place: str,
    names: Iterable[str],
    defaults: Mapping[str, object] | None = None,
) -> None:
    """Add arguments to a command.

    Parameters
    ----------
    parser : of the command
    place : the function of the command, as in `documented`
    names : parameters of the function, arguments without a flag, and flags of the command
    defaults : values on the command line that differ from those of the function
    """
    parameters, defaults = documented(place).parameters, defaults or {}
    for name in names:
        if name in OF_COMMANDS:
            parser.add_argument(name, **OF_COMMANDS[name])
        elif name in POSITIONAL:
            settings = POSITIONAL[name]
            if default := defaults.get(name):
                help = f"{settings['help']} (default: {default})"
                settings = settings | {"nargs": "?", "default": default, "help": help}
            parser.add_argument(name, **settings)
        else:
            _add_flag(parser, name, parameters[name].text, defaults.get(name))
            if isinstance(parameters[name].default, int | float | str):
                parser.set_defaults(**{name: parameters[name].default})


def flag_of(name: str) -> str:
    """Return the flag of a parameter."""
    return REPEATED.get(name) or OTHER_NAMES.get(name) or f"--{name.replace('_', '-')}"


def _add_flag(parser: ArgumentParser, name: str, text: str, default: object) -> None:
    settings = FLAGS[flag_of(name)] | {"dest": name}
    if name in REPEATED:
        settings |= {"action": "append"}
        text = f"{text}; repeat it for each of them"
    if default is not None:
        settings |= {"default": default}
    text = text.removeprefix("whether to ").rstrip(".")
    # argparse replaces %(...) in help
    help = f"{text[:1].lower()}{text[1:]}".replace("%", "%%")
    parser.add_argument(flag_of(name), help=help, **settings)


def new_parser(prog: str, description: str = "", examples: str = "") -> Parser:
    """Return a parser whose examples keep their lines."""
    return Parser(
        prog=prog,
        description=description,
        epilog=examples,
        formatter_class=RawDescriptionHelpFormatter,
    )
