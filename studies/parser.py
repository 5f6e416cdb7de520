"""What the command line takes: commands, their arguments and flags."""

import argparse
import os
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from .registry import STUDIES, Study


def parser() -> argparse.ArgumentParser:
    """The parser; `command` of what it finds names the command."""
    whole = argparse.ArgumentParser(
        prog="ringwear",
        description="Wear of a ringed punch on an elastic half-space: finite elements, "
        "dimensionality reduction and "
        "direct integration, side by side.",
    )
    whole.add_argument("--version", action="version", version=f"ringwear {_version()}")
    commands = whole.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser(
        "run", help="compute a scene by every method it names, and compare them"
    )
    run.add_argument(
        "scene",
        nargs="?",
        default="five_rings",
        help="a TOML file or a bundled scene (default: five_rings)",
    )
    run.add_argument(
        "--out", type=_directory, help="directory for results (default: results/SCENE)"
    )
    run.add_argument("--rtol", type=float, help="relative accuracy, in place of the scene's")
    run.add_argument("--methods", help="methods, comma-separated, in place of the scene's")
    run.add_argument(
        "--no-figures", action="store_true", help="numbers only: neither figures nor the report"
    )
    run.add_argument("--no-report", action="store_true", help="figures, but no report.html")
    run.add_argument("--csv", action="store_true", help="the results as CSV tables, too")
    _add_memory(run)
    run.set_defaults(command="run")

    plan = commands.add_parser("plan", help="say what a scene will take, by a coarse probe of it")
    plan.add_argument("scene", help="a TOML file or a bundled scene")
    plan.add_argument(
        "--check",
        action="store_true",
        help="also condense it, and report the stability of the multipliers",
    )
    plan.set_defaults(command="plan")

    mesh = commands.add_parser(
        "mesh", help="mesh the half-space of a scene: a VTU file and a figure"
    )
    mesh.add_argument("scene", help="a TOML file or a bundled scene")
    mesh.add_argument("--out", type=_directory, help="directory (default: results/SCENE)")
    mesh.set_defaults(command="mesh")

    compare = commands.add_parser(
        "compare", help="two folders of results, or scenes: what differs, drawn together"
    )
    for side in "AB":
        compare.add_argument(
            side, help="a folder that `ringwear run` has written, a TOML file or a bundled scene"
        )
    compare.add_argument(
        "--out",
        type=_directory,
        default=Path("results/compare"),
        help="directory (default: results/compare)",
    )
    compare.set_defaults(command="compare")

    studies = commands.add_parser("study", help="a study: figures, tables and a conclusion")
    names = studies.add_subparsers(required=True, metavar="NAME")
    for name, study in STUDIES.items():
        _add_study(names.add_parser(name, help=study.purpose), name, study)

    sweep = commands.add_parser(
        "sweep", help="a map: many scenes over axes of scene keys, kept in one labelled store"
    )
    sweep.add_argument("file", help="a sweep file (studies/sweep/README.md), or a bundled sweep")
    sweep.add_argument(
        "--out", type=Path, default=None, help="directory for the store (default: results/FILE)"
    )
    sweep.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler, to compute on its workers"
    )
    cores = os.cpu_count() or 1
    sweep.add_argument(
        "--workers", type=int, default=cores, help="processes on this machine (default: its cores)"
    )
    _add_memory(sweep)
    sweep.add_argument(
        "--dry-run", action="store_true", help="say what it will take, without computing"
    )
    sweep.add_argument("--resume", action="store_true", help="go on with what is in the directory")
    sweep.add_argument(
        "--retry-failed",
        action="store_true",
        help="with --resume: try again the scenes that failed",
    )
    sweep.set_defaults(command="sweep")

    scenes = commands.add_parser("scenes", help="list the bundled scenes")
    scenes.set_defaults(command="scenes")
    return whole


def _add_memory(parser: argparse.ArgumentParser) -> None:
    help = (
        "most memory in GiB; what would need more is refused before it starts (default: what the "
        "machine has)"
    )
    parser.add_argument("--memory", type=float, metavar="GIB", help=help)


def _add_study(parser: argparse.ArgumentParser, name: str, study: Study) -> None:
    parser.add_argument(
        "scene", nargs="?", default=study.scene, help=f"a scene (default: {study.scene})"
    )
    parser.add_argument(
        "--out", type=_directory, help=f"directory for results (default: results/{name})"
    )
    parser.add_argument("--quick", action="store_true", help="a smaller version of the study")
    for flag, settings in study.options:
        parser.add_argument(flag, **settings)
    parser.set_defaults(command="study", study=name)


def _version() -> str:
    try:
        return version("ringwear")
    except PackageNotFoundError:
        return "(not installed)"


def _directory(text: str) -> Path:
    if not text.strip():
        raise argparse.ArgumentTypeError("is empty: give a directory")
    return Path(text)
