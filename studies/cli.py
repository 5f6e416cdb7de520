"""The command line: `ringwear run | plan | mesh | study | sweep | scenes`.

Exit status: 0 done and the methods agree within their stated uncertainty; 3 done and they disagree, or one cannot reach
the accuracy asked for; 2 bad input; 1 anything else, and when stopped by Ctrl-C or SIGTERM (finished rows of a study
and scenes of a sweep are kept).
"""

import argparse
import logging
import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from ringwear.meshes.errors import RingwearError, SceneError
from ringwear.studies.problem.scene import Scene, bundled
from ringwear.studies.progress import LOG, STAGES
from ringwear.studies.registry import INTERRUPTED, STUDIES, Study

if TYPE_CHECKING:
    from ringwear.studies.crosscheck.dataset import Result
DONE, FAILED, BAD_INPUT, DISAGREE = 0, 1, 2, 3
EVERY = 10.0  # seconds between lines of progress that are not for a terminal


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    options = _parser().parse_args(arguments)
    LOG.setLevel(logging.INFO)
    STAGES.setLevel(logging.WARNING if options.command in (_study, _sweep) else logging.NOTSET)
    # a batch system ends a job by SIGTERM: as by Ctrl-C, what is finished is kept and nothing half-written is left
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    if not any(isinstance(handler, Terminal) for handler in LOG.handlers):
        LOG.addHandler(Terminal())
    try:
        return int(options.command(options))
    except SceneError as error:
        print(f"ringwear: {error}", file=sys.stderr)
        return BAD_INPUT
    except RingwearError as error:
        print(f"ringwear: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print("ringwear: stopped; nothing half-written was left", file=sys.stderr)
        return FAILED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="ringwear",
        description="Wear of a ringed punch on an elastic half-space: finite elements, dimensionality reduction and "
        "direct integration, side by side.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser("run", help="compute a scene by every method it names, and compare them")
    run.add_argument("scene", nargs="?", default="five_rings", help="a TOML file or a bundled scene (default: five_rings)")
    run.add_argument("--out", type=Path, default=None, help="directory for results (default: results/SCENE)")
    run.add_argument("--rtol", type=float, help="relative accuracy, in place of the scene's")
    run.add_argument("--methods", help="methods, comma-separated, in place of the scene's")
    _add_memory(run)
    run.set_defaults(command=_run)

    plan = commands.add_parser("plan", help="say what a scene will take, without computing it")
    plan.add_argument("scene", help="a TOML file or a bundled scene")
    plan.add_argument("--check", action="store_true", help="also condense it, and report the stability of the multipliers")
    plan.set_defaults(command=_plan)

    mesh = commands.add_parser("mesh", help="mesh the half-space of a scene: a VTU file and a figure")
    mesh.add_argument("scene", help="a TOML file or a bundled scene")
    mesh.add_argument("--out", type=Path, default=None, help="directory (default: results/SCENE)")
    mesh.set_defaults(command=_mesh)

    studies = commands.add_parser("study", help="a study: figures, tables and a conclusion")
    names = studies.add_subparsers(required=True, metavar="NAME")
    for name, study in STUDIES.items():
        _add_study(names.add_parser(name, help=study.purpose), name, study)

    sweep = commands.add_parser("sweep", help="a map: many scenes over axes of scene keys, kept in one labelled store")
    sweep.add_argument("file", help="a sweep file (studies/sweep/README.md), or a bundled sweep")
    sweep.add_argument("--out", type=Path, default=None, help="directory for the store (default: results/FILE)")
    sweep.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, to compute on its workers")
    cores = os.cpu_count() or 1
    sweep.add_argument("--workers", type=int, default=cores, help="processes on this machine (default: its cores)")
    _add_memory(sweep)
    sweep.add_argument("--dry-run", action="store_true", help="say what it will take, without computing")
    sweep.add_argument("--resume", action="store_true", help="go on with what is in the directory")
    sweep.set_defaults(command=_sweep)

    scenes = commands.add_parser("scenes", help="list the bundled scenes")
    scenes.set_defaults(command=_scenes)
    return parser


def _add_memory(parser: argparse.ArgumentParser) -> None:
    help = "most memory in GiB; what would need more is refused before it starts (default: what the machine has)"
    parser.add_argument("--memory", type=float, metavar="GIB", help=help)


def _add_study(parser: argparse.ArgumentParser, name: str, study: Study) -> None:
    parser.add_argument("scene", nargs="?", default=study.scene, help=f"a scene (default: {study.scene})")
    parser.add_argument("--out", type=Path, default=None, help=f"directory for results (default: results/{name})")
    parser.add_argument("--quick", action="store_true", help="a smaller version of the study")
    for flag, settings in study.options:
        parser.add_argument(flag, **settings)
    parser.set_defaults(command=_study, study=name)


class Terminal(logging.Handler):
    """The log on standard error: on a terminal unfinished lines are written over; elsewhere one shows now and then."""

    _last = float("-inf")

    def emit(self, record: logging.LogRecord) -> None:
        line, now = record.getMessage(), time.monotonic()
        unfinished = line.endswith("...")
        if sys.stderr.isatty():
            print(f"\r\033[K{line}", end="" if unfinished else "\n", file=sys.stderr, flush=True)
        elif not unfinished or now - self._last > EVERY:
            self._last = now
            print(line, file=sys.stderr, flush=True)


def _directory(options: argparse.Namespace) -> Path:
    out = options.out or Path("results") / Path(options.scene).stem
    if out.exists() and not out.is_dir():
        raise SceneError(f"--out {out} is a file: give a directory")
    return Path(out)


def _run(options: argparse.Namespace) -> int:
    from ringwear.studies.crosscheck import agreement
    from ringwear.studies.crosscheck.run import run
    from ringwear.studies.crosscheck.scope import beyond_memory, expected, machine_memory
    from ringwear.studies.output import write

    scene = Scene.load(options.scene)
    if options.rtol is not None:
        scene = scene.changed(accuracy__rtol=options.rtol)
    if options.methods is not None:
        scene = scene.changed(methods=[name.strip() for name in options.methods.split(",") if name.strip()])
    out = _directory(options)
    if refusal := beyond_memory(expected(scene), options.memory or machine_memory()):
        raise SceneError(refusal)
    result = run(scene)
    written = write(result, out)
    _say_what(scene)
    _say_verdict(result)
    print(f"\n{len(written)} files in {out}: {', '.join(written)}")
    return DISAGREE if result.verdict == agreement.DISAGREE or result.short_of else DONE


def _say_what(scene: Scene) -> None:
    from ringwear.studies.crosscheck.scope import left_out, modelled

    print(f"\n{scene.title or 'Untitled scene'}\n\nModelled")
    for line in modelled(scene):
        print(f"  {line}")
    print("Left out")
    for what, why in left_out(scene).items():
        print(f"  {what}: {why}")


def _say_verdict(result: "Result") -> None:
    print("\nMethod    unknowns   seconds   own error estimate (relative, of the indentation)")
    for name, solution in result.solutions.items():
        seconds = sum(result.stages[name].seconds.values())
        parts = ", ".join(f"{part} {value:.1e}" for part, value in solution.parts.items())
        print(f"{name:<9}{solution.unknowns:>9}{seconds:>10.3f}   {parts}")
    if result.agreement:
        print("\nAgreement, relative             difference  uncertainty")
    for row in result.agreement:
        pair, verdict = f"{row.methods[0]}, {row.methods[1]}", "" if row.agrees else f"   {row.verdict}"
        print(f"  {row.quantity:<24}{pair:<14}{row.difference:8.1e}{row.uncertainty:10.1e}{verdict}")
    for both in result.operators:
        print(
            f"As operators, {both.methods[0]} and {both.methods[1]} differ by {both.rings:.1e} over all steady states and "
            f"{both.history:.1e} along this history; stability {both.stability:.2f}, residual {both.residual:.1e}"
        )
    for anchor in result.anchors:
        if not anchor.holds:
            print(f"{anchor.method} does not hold to {anchor.name}: off by {anchor.difference:.1e}, "
                  f"more than {anchor.tolerance:.1e}")  # fmt: skip
    print(f"{len(result.anchors)} anchors (closed forms and balances), "
          f"{'all hold' if all(anchor.holds for anchor in result.anchors) else 'NOT ALL HOLD'}.")  # fmt: skip
    rtol = result.scene.accuracy.rtol
    for name, solution in result.solutions.items():
        if beyond := solution.beyond(rtol):
            listed = ", ".join(f"{quantity} {error:.1e}" for quantity, error in beyond.items())
            print(f"{name} says of itself that it errs by more than the {rtol:.0e} asked for in: {listed}")
    for row in result.agreement:
        if row.remark:
            print(f"{row.quantity} is undecided between {row.methods[0]} and {row.methods[1]}: {row.remark}")
    for note in result.notes:
        print(f"note: {note}")
    if result.agreement:
        print(result.verdict_in_words)


def _plan(options: argparse.Namespace) -> int:
    from ringwear.studies.crosscheck.run import run
    from ringwear.studies.crosscheck.scope import plan

    scene = Scene.load(options.scene)
    _say_what(scene)
    print("\nBy method")
    for line in plan(scene):
        print(f"  {line}")
    # the finite elements' multipliers against a compliance that resolves every pressure they have
    for both in run(scene.changed(methods=["mdr", "fem"])).operators if options.check else ():
        print(
            f"\nMultipliers: inf-sup constant {both.stability**0.5:.2f}, least ratio of energies {both.stability:.2f} "
            f"({both.methods[0]} over {both.methods[1]}); over all steady states they differ by {both.rings:.1e}"
        )
    return DONE


def _mesh(options: argparse.Namespace) -> int:
    from ringwear.meshes.half_space import quality
    from ringwear.studies.methods.fem import half_space_mesh
    from ringwear.studies.output import write_mesh

    scene, out = Scene.load(options.scene), _directory(options)
    meshed = half_space_mesh(scene.problem)
    written = write_mesh(scene, meshed, out)
    mesh, shape = meshed.mesh, quality(meshed.mesh)
    kind = {3: "triangles", 4: "quadrilaterals"}[len(mesh.t)]
    print(f"{mesh.nelements} {kind} by {meshed.mesher}, {len(mesh.boundaries['contact'])} facets on the contact, "
          f"quality (least sine) {shape.min():.2f} to {shape.max():.2f}, mean {shape.mean():.2f}")  # fmt: skip
    for note in meshed.notes:
        print(f"note: {note}")
    print(f"{len(written)} files in {out}: {', '.join(written)}")
    return DONE


def _study(options: argparse.Namespace) -> int:
    from ringwear.studies.output import whole
    from ringwear.studies.tables import keeping_rows

    scene = Scene.load(options.scene)
    options.out = out = options.out or Path("results") / options.study
    with whole(_directory(options)) as hidden:
        conclusions = list[str]()
        with keeping_rows(conclusions):
            conclusions += STUDIES[options.study].conduct(scene, hidden, options)
        if conclusions == [INTERRUPTED]:
            # stopped between its rows: tables are whole after every row, but a figure may be half there
            for file in set(hidden.iterdir()) - set(hidden.glob("*.csv")):
                file.unlink()
        written = sorted(file.name for file in hidden.iterdir())
    print("\n".join(conclusions))
    print(f"{len(written)} files in {out}: {', '.join(written)}")
    return FAILED if INTERRUPTED in conclusions else DONE


def _sweep(options: argparse.Namespace) -> int:
    from ringwear.studies.sweep.run import swept

    if options.workers < 1:
        raise SceneError(f"--workers {options.workers}: give 1 or more")
    options.scene = options.file
    conclusions, complete = swept(options.file, _directory(options), options)
    print("\n".join(conclusions))
    return DONE if complete else FAILED


def _scenes(_: argparse.Namespace) -> int:
    for name in bundled():
        print(f"{name:<14}{Scene.load(name).title}")
    return DONE
