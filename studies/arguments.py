"""The arguments of commands: parameters of functions as flags, and their docstrings as help.

Help and refusals of the command line need only this file, which loads no numerical libraries.
"""

import re
from argparse import SUPPRESS, ArgumentParser, ArgumentTypeError, RawDescriptionHelpFormatter
from collections.abc import Callable
from contextlib import suppress
from shutil import get_terminal_size
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from .crosscheck import nearest, package_versions
from .documented import documented
from .named_studies import STUDIES

if TYPE_CHECKING:
    from .crosscheck import Scene, UnitNames


def _reads(read: Callable[[str], Any], remedy: str) -> Callable[[str], Any]:
    """Return the function `read`, with the remedy as error message if it cannot read a text."""

    def read_or_refuse(text: str) -> Any:
        with suppress(ValueError):
            return read(text)
        raise ArgumentTypeError(f"{text!r}: give {remedy}")

    return read_or_refuse


def _not_empty(text: str) -> str:
    if not text.strip():
        raise ValueError(text)
    return text


def _above_zero(text: str) -> float:
    if not float(text) > 0:
        raise ValueError(text)
    return float(text)


def _by_name(text: str) -> dict[str, str]:
    pairs = dict(pair.partition("=")[::2] for pair in text.split(","))
    if not all(name and ours for name, ours in pairs.items()):
        raise ValueError(text)
    return pairs


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(","))


def _quantity(text: str) -> float | str:
    """Return a number, or a text that begins with one, which may have a unit."""
    with suppress(ValueError):
        return float(text)
    if not re.match(r"[-+.\s]*\d", text):
        raise ValueError(text)
    return text


def _noise(text: str) -> str | dict[str, str]:
    return PAIRS(text) if "=" in text else text


NUMBER = _reads(float, "a number, such as 1e-4")
POSITIVE = _reads(_above_zero, "a positive number")
WHOLE = _reads(int, "a whole number")
QUANTITY = _reads(_quantity, "a number, such as 0.05 or '2 mm'")
QUANTITIES = _reads(
    lambda text: tuple(map(_quantity, text.split(","))), "numbers, such as 0.2,0.1,0.05"
)
PAIRS = _reads(_by_name, "theirs=ours, such as p=pressure,r=radius")
DIRECTORY, FILE = _reads(_not_empty, "a directory"), _reads(_not_empty, "a file")

FLAGS: dict[str, tuple[str, Callable[[str], Any]]] = {
    "against": ("{size,unknowns,seconds}", str),
    "by": ("COLUMN", str),
    "columns": ("THEIRS=OURS,...", PAIRS),
    "cycle": ("LENGTH", str),
    "degree": ("K", WHOLE),
    "density": ("X", str),
    "element": ("NAME", str),
    "elements": ("NAME", str),
    "memory": ("GIB", POSITIVE),
    "mesh": ("FILE", FILE),
    "meshes": ("FILE", FILE),
    "methods": ("A,B", _names),
    "noise": ("X", _noise),
    "out": ("DIR", DIRECTORY),
    "parameters": ("NAME,...", _names),
    "program": ("{calculix,abaqus}", str),
    "quantities": ("A,B", _names),
    "radii": ("R,...", QUANTITIES),
    "reach": ("R", QUANTITY),
    "right": ("[NAME=]VALUE", str),
    "rtol": ("X", NUMBER),
    "scheduler": ("ADDRESS", str),
    "size": ("H", QUANTITY),
    "sizes": ("H,...", QUANTITIES),
    "steps": ("H,...", QUANTITIES),
    "times": ("T", QUANTITY),
    "tolerance": ("X", POSITIVE),
    "units": ("UNITS", str),
    "vary": ("KEY=[geom:]LOW:HIGH:N", str),
    "within": ("X", POSITIVE),
    "workers": ("N", WHOLE),
}
"""Form and type of parameters that are flags; so are all parameters that are False by default.

A flag means the same in all commands.
"""
KINDS = {"radii": "length", "reach": "length", "size": "length", "sizes": "length"} | {
    "steps": "time",
    "times": "time",
}
"""Kinds of the units that the numbers of flags may have."""
IN_PUNCH_RADII = ("radii", "reach")
"""Flags whose numbers without a unit are multiples of the radius of the punch."""
OTHER_NAMES = {"program": "for", "times": "time", "meshes": "mesh", "elements": "element"}
"""Names of flags that differ from those of their parameters."""
REPEATED = {"quantities": "extend"} | dict.fromkeys(
    ("times", "meshes", "elements", "right", "vary"), "append"
)
"""How a flag that is repeated adds to its parameter."""
FORMS = {"scene": "scene", "theirs": "FILE", "words": "[NAME] FILE"}
"""Forms of arguments without a flag that are not the name of the parameter in capitals."""
SHARED = {
    "scene": "a TOML file, or the name of a bundled scene",
    "out": "the directory to write to (default: results/NAME with the name of the scene, study or "
    "file)",
}
"""Help of arguments that several commands have."""


class Parser(ArgumentParser):
    """A parser of a command, which suggests the nearest name for an unknown one.

    Arguments that are not given are left to the defaults of the functions.
    """

    def __init__(self, description: str = "", **settings: Any) -> None:
        super().__init__(
            description=fill(description, get_terminal_size().columns - 2),
            formatter_class=RawDescriptionHelpFormatter,
            argument_default=SUPPRESS,
            **settings,
        )

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Return what is read; each command refuses what it does not know by itself."""
        options, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return options, unknown

    def error(self, message: str) -> NoReturn:
        """Print the usage of the command and the error, and exit with status 2."""
        from .crosscheck import bundled

        suggestion = ""
        if choice := re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message):
            suggestion = nearest(choice[1], re.findall(r"[\w-]+", choice[2]))
            if choice[1] in bundled() or choice[1].endswith(".toml"):
                suggestion = f"ringwear run {choice[1]}"
        elif unknown := re.search(r"unrecognized arguments: --([\w-]+)", message):
            near = nearest(unknown[1], re.findall(r"--([\w-]+)", self.format_usage()))
            suggestion = near and f"--{near}"
        if message.startswith("unrecognized arguments") and not suggestion:
            super().error(f"{message}; leave it out: --help lists what the command takes")
        super().error(f"{message}; did you mean {suggestion}?" if suggestion else message)


def in_units(
    scene: "Scene", given: dict[str, Any], names: "UnitNames | None" = None
) -> dict[str, Any]:
    """Return options of a command in which numbers with a unit are numbers in those of a scene.

    Parameters
    ----------
    scene : of the command
    given : options by the names of their parameters
    names : units of the numbers, if they are not those of the scene
    """
    from .crosscheck import number_of

    names = names or scene.unit_names

    def number(name: str, value: float | str) -> float:
        if not isinstance(value, str):
            return value
        found = number_of(value, f"--{OTHER_NAMES.get(name, name)}", KINDS[name], names)
        return found / scene.punch.radius if name in IN_PUNCH_RADII else found

    converted = dict(given)
    for name in KINDS.keys() & given.keys():
        value = given[name]
        several = isinstance(value, list | tuple)
        converted[name] = [number(name, each) for each in value] if several else number(name, value)
    return converted


def add_arguments(parser: Parser, place: str, conduct: str) -> None:
    """Add the arguments of a command: the parameters of two functions that have a form.

    Parameters
    ----------
    parser : of the command
    place : the function of the command in Python, as in `documented`
    conduct : the function that conducts the command, whose parameters take precedence; those that
        can be given by position are arguments without a flag
    """
    own = documented(conduct).parameters
    for name, parameter in (documented(place).parameters | own).items():
        text = (parameter.text or SHARED.get(name, "")).removeprefix("whether to ").rstrip(".")
        # argparse replaces %(...) in help
        help = f"{text[:1].lower()}{text[1:]}".replace("%", "%%")
        flag = f"--{OTHER_NAMES.get(name, name).replace('_', '-')}"
        if name in own and parameter.by_position:
            one, several = ("?", "*") if parameter.default else (None, "+")
            nargs = several if parameter.type.startswith("Sequence") else one
            parser.add_argument(name, nargs=nargs, metavar=FORMS.get(name, name.upper()), help=help)
        elif parameter.default == "False":
            parser.add_argument(flag, action="store_true", help=help)
        elif name in FLAGS:
            form, kind = FLAGS[name]
            if name in OTHER_NAMES and name in REPEATED:
                help = f"{help}; repeat it for each of them"
            parser.add_argument(
                flag,
                dest=name,
                metavar=form,
                type=kind,
                action=REPEATED.get(name, "store"),
                required=not parameter.default,
                help=help,
            )


class Command(NamedTuple):
    """A command, which the function of its name in `commands.py` conducts: `_run` conducts `run`.

    Parameters
    ----------
    place : the function whose docstring is the help, as in `documented`, and whose other parameters
        are arguments, too; by default that which conducts the command
    examples : text at the end of the help
    """

    place: str = ""
    examples: str = ""


EXAMPLES = """examples:
  ringwear run                          compute the scene five_rings
  ringwear scenes sphere > mine.toml    start a scene of your own
  ringwear run mine.toml --rtol 1e-3    compute it with another tolerance
  ringwear deck mine.toml --for abaqus  write input files for another program
  ringwear check mine.toml abaqus.csv   check another program's results
  ringwear fit mine.toml data.csv --parameters punch.wear_coefficient
                                        fit wear coefficients to measurements
  ringwear study convergence --quick    compare orders with theory
"""
DECK_EXAMPLES = """examples:
  ringwear deck mine.toml --for calculix --out deck       the start and the last time
  ringwear deck five_rings --for calculix --time 0.1 --time 2 --size 0.05 --reach 500
  cd deck; ccx prescribed; ringwear check scene.toml prescribed.dat
"""
ORDERS_EXAMPLES = """examples:
  ringwear orders levels.csv --by h                     orders of all columns, in Markdown
  ringwear orders levels.csv --by h --right depth=1.2 --tolerance 1e-3
                                                        also computed over right values
  ringwear orders errors.csv --by h --right 0 --latex   columns that hold errors, for a paper
"""
CHALLENGE_EXAMPLES = """examples:
  ringwear challenge --list                             list the problems
  ringwear challenge 03_five_rings > mine.toml          print a problem, as a scene
  ringwear challenge 03_five_rings mine.csv             compare your results with it
  ringwear challenge 03_mine.csv                        the same, by the number in the file's name
  ringwear challenge 13 mine.csv                        compare a table of cases with the answers
"""

COMMANDS = {
    "run": Command("crosscheck.result.run:run"),
    "check": Command("check.check:check"),
    "fit": Command("fit.fit:fit"),
    "plan": Command("wear_step.plan:plan"),
    "mesh": Command(),
    "compare": Command("comparison:compare"),
    "study": Command("named_studies:study"),
    "orders": Command("study.orders:orders", ORDERS_EXAMPLES),
    "sweep": Command("sweep.sweep:sweep"),
    "scenes": Command(),
    "deck": Command("decks.deck:deck", DECK_EXAMPLES),
    "challenge": Command(examples=CHALLENGE_EXAMPLES),
}


PURPOSE = (
    "Compute how a rigid punch of concentric rings wears on an elastic half-space, by finite "
    "elements, dimensionality reduction, boundary elements and direct integration, and report how "
    "far these methods agree."
)


def read_arguments(arguments: list[str]) -> dict[str, Any]:
    """Return the name of a command, its `options`, and its `usage`.

    It prints what the command line asks for, help or version, and refuses what is no argument; both
    end the process.
    """
    parser = Parser(PURPOSE, prog="ringwear", epilog=EXAMPLES)
    # reading the versions of packages takes longer than the help
    version = package_versions()["ringwear"] if "--version" in arguments else ""
    parser.add_argument("--version", action="version", version=f"ringwear {version}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")
    called = next(iter(arguments), "")
    for name, command in COMMANDS.items():
        # the sources of other commands are not read if one is called
        if called in COMMANDS and called != name:
            commands.add_parser(name)
            continue
        conduct = f"commands:_{name}"
        place = command.place or conduct
        purpose = documented(place).purpose
        subparser = commands.add_parser(
            name, help=purpose, description=purpose, epilog=command.examples
        )
        if name != "study":
            add_arguments(subparser, place, conduct)
            subparser.set_defaults(usage=subparser.format_usage())
            continue
        names = subparser.add_subparsers(required=True, metavar="NAME", dest="study")
        for study, row in STUDIES.items():
            subparser = names.add_parser(study, help=row.purpose, description=row.purpose)
            add_arguments(subparser, row.place, conduct)
            if "quantities" in row.options:
                subparser.add_argument(
                    "--quantity",
                    action="append",
                    dest="quantities",
                    metavar="FILE.py:NAME",
                    help="a function of your own that takes the result of a run and returns a "
                    "number; may be repeated",
                )
            subparser.set_defaults(usage=subparser.format_usage())
    options = vars(parser.parse_args(arguments))
    return {name: options.pop(name) for name in ("command", "usage")} | {"options": options}
