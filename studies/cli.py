"""The command line: `ringwear run | plan | mesh | compare | study | sweep | scenes`.

Exit status: 0 done and the methods agree within their stated uncertainty; 3 done and they disagree,
or one cannot reach the accuracy asked for; 2 bad input; 1 anything else, such as a figure that
could not be drawn or scenes of a sweep that failed, and when stopped by Ctrl-C or SIGTERM (finished
rows of a study and scenes of a sweep are kept).
"""

import argparse
import logging
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ..meshes.errors import RingwearError, SceneError
from .output.folder import Folder, held
from .parser import parser
from .problem.scene import Scene, bundled
from .progress import LOG, STAGES, STOPPED, Terminal
from .registry import INTERRUPTED, STUDIES

if TYPE_CHECKING:
    from .crosscheck.dataset import Result

DONE, FAILED, BAD_INPUT, DISAGREE = 0, 1, 2, 3


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    options = parser().parse_args(arguments)
    LOG.setLevel(logging.INFO)
    STAGES.setLevel(
        logging.WARNING if options.command in ("plan", "study", "sweep") else logging.NOTSET
    )
    if not any(isinstance(handler, Terminal) for handler in LOG.handlers):
        LOG.addHandler(Terminal())
    try:
        with _terminable():
            return COMMANDS[options.command](options)
    except SceneError as error:
        print(f"ringwear: {error}", file=sys.stderr)
        return BAD_INPUT
    except RingwearError as error:
        print(f"ringwear: {error}", file=sys.stderr)
        return FAILED
    except OSError as error:
        print(
            f"ringwear: {error.filename or 'a file'} could not be written: "
            f"{error.strerror or error}",
            file=sys.stderr,
        )
        return FAILED
    except KeyboardInterrupt:
        print("ringwear: stopped; nothing half-written was left", file=sys.stderr)
        return FAILED


@contextmanager
def _terminable() -> Iterator[None]:
    """SIGTERM, by which a batch system ends a job, ends the work as Ctrl-C does."""
    STOPPED.clear()
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = signal.SIGINT, signal.SIGTERM
    before = [signal.signal(number, _stop) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


def _stop(*_: object) -> None:
    STOPPED.set()
    raise KeyboardInterrupt


def _results_of(options: argparse.Namespace) -> Path:
    return options.out or Path("results") / Path(options.scene).stem


def _run(options: argparse.Namespace) -> int:
    scene = Scene.load(options.scene)
    if options.rtol is not None:
        scene = scene.changed(accuracy__rtol=options.rtol)
    if options.methods is not None:
        scene = scene.changed(
            methods=[name.strip() for name in options.methods.split(",") if name.strip()]
        )
    # that the folder can be written to is known before the work
    with held(_results_of(options), "run") as folder:
        from .crosscheck.sizes import beyond_memory, machine_memory, predict_memory

        if refusal := beyond_memory(predict_memory(scene), options.memory or machine_memory()):
            raise SceneError(refusal)
        from .crosscheck import agreement
        from .crosscheck.run import run
        from .output.of_run import draw, write_numbers
        from .output.side_by_side import Job, make
        from .report.printed import print_result

        result = run(scene)
        write_numbers(result, folder, tables=options.csv)
        # nobody waits for the answer until all is drawn; and what is not out yet would be written
        # by a forked process, too
        with suppress(BrokenPipeError):
            print_result(result)
            sys.stdout.flush()
        failures = draw(result, folder, figures=not options.no_figures)
        if not (options.no_figures or options.no_report):
            failures += make(
                [Job("report.html", lambda path: _write_report(result, folder.hidden, path))],
                [],
                folder.hidden,
            )
    _say_files(folder)
    for failure in failures:
        print(f"ringwear: {failure}", file=sys.stderr)
    if failures:
        return FAILED
    return DISAGREE if result.verdict == agreement.DISAGREE or result.short_of else DONE


def _write_report(result: "Result", figures: Path, path: Path) -> None:
    from .report.page import write_report

    write_report(result, figures, path)


def _say_files(folder: Folder) -> None:
    print(f"\n{len(folder.published)} files in {folder.out}: {', '.join(folder.published)}")
    for note in folder.notes:
        print(f"note: {note}")
    if foreign := folder.foreign():
        shown = ", ".join(foreign[:5]) + (" ..." if len(foreign) > 5 else "")
        print(
            f"note: {len(foreign)} other files there are not of ringwear, and were left alone: "
            f"{shown}"
        )


def _plan(options: argparse.Namespace) -> int:
    from .crosscheck.plan import plan
    from .crosscheck.run import run
    from .crosscheck.scope import time_scale
    from .report.printed import print_scope

    scene = Scene.load(options.scene)
    print(f"\n{scene.title or 'Untitled scene'}")
    for line in time_scale(scene):
        print(line)
    print()
    print_scope(scene)
    print("\nBy method")
    for line in plan(scene):
        print(f"  {line}")
    # the finite elements' multipliers against a compliance that resolves every pressure they have
    for both in run(scene.changed(methods=["mdr", "fem"])).operators if options.check else ():
        print(
            f"\nMultipliers: inf-sup constant {both.stability**0.5:.2f}, least ratio of energies "
            f"{both.stability:.2f} "
            f"({both.methods[0]} over {both.methods[1]}); over all steady states they differ by "
            f"{both.rings:.1e}"
        )
    return DONE


def _mesh(options: argparse.Namespace) -> int:
    scene = Scene.load(options.scene)
    with held(_results_of(options), "mesh") as folder:
        from ..meshes.half_space import quality
        from .methods.fem import half_space_mesh
        from .output.of_run import write_mesh

        meshed = half_space_mesh(scene.problem)
        write_mesh(scene, meshed, folder)
    mesh, shape = meshed.mesh, quality(meshed.mesh)
    kind = {3: "triangles", 4: "quadrilaterals"}[len(mesh.t)]
    print(
        f"{mesh.nelements} {kind} by {meshed.mesher}, {len(mesh.boundaries['contact'])} facets on "
        "the contact, "
        f"quality (least sine) {shape.min():.2f} to {shape.max():.2f}, mean {shape.mean():.2f}"
    )
    for note in meshed.notes:
        print(f"note: {note}")
    _say_files(folder)
    return DONE


def _compare(options: argparse.Namespace) -> int:
    with held(options.out, "compare") as folder:
        from .figures.comparison import OVER_RADIUS, OVER_TIME, draw_comparison
        from .report import comparison
        from .report.printed import print_rows
        from .tables import Table

        one, other = comparison.both(options.A, options.B)
        keys, answers = comparison.scene_rows(one, other), comparison.answer_rows(one, other)
        curves = {name: (one.curve(name), other.curve(name)) for name in (*OVER_RADIUS, *OVER_TIME)}
        if not any(found is not None for pair in curves.values() for found in pair):
            raise SceneError(
                "neither result holds a history or a steady state: there is nothing to compare"
            )
        Table(folder.hidden / "scenes.csv", keys.headers, keys.rows)
        Table(folder.hidden / "answers.csv", answers.headers, answers.rows)
        draw_comparison((one.scene, other.scene), curves, folder.hidden / "comparison.png")
    print(f"A: {one.name}\nB: {other.name}\n")
    print_rows(keys)
    print()
    print_rows(answers)
    _say_files(folder)
    return DONE


def _study(options: argparse.Namespace) -> int:
    from .tables import keeping_rows

    scene = Scene.load(options.scene)
    study = STUDIES[options.study]
    if not scene.problem.full_contact:
        raise SceneError(
            f"study {options.study} is about flat punches under a force: leave out punch.recess "
            "and "
            "punch.profile, and give load.normal_force"
        )
    with held(options.out or Path("results") / options.study, f"study {options.study}") as folder:
        conclusions = list[str]()
        with keeping_rows(conclusions):
            conclusions += study.conduct(scene, folder.hidden, options)
        if conclusions == [INTERRUPTED]:
            # stopped between its rows: tables are whole after every row, but a figure may be half
            # there
            for file in set(folder.hidden.iterdir()) - set(folder.hidden.glob("*.csv")):
                file.unlink()
            if not any(_rows(file) for file in folder.hidden.iterdir()):
                raise KeyboardInterrupt
        failures = list[str]()
        with keeping_rows(conclusions):
            from .output.side_by_side import Job, make
            from .report.page import write_study

            named = options.study, study.purpose
            page = Job(
                "report.html",
                lambda path: write_study(named, scene, conclusions, folder.hidden, path),
            )
            failures += make([page], [], folder.hidden)
    print("\n".join(conclusions))
    _say_files(folder)
    for failure in failures:
        print(f"ringwear: {failure}", file=sys.stderr)
    return FAILED if failures or INTERRUPTED in conclusions else DONE


def _rows(table: Path) -> int:
    """Rows of a table below its heading."""
    return len(table.read_text("utf-8").splitlines()) - 1


def _sweep(options: argparse.Namespace) -> int:
    from .sweep.conduct import swept

    if options.workers < 1:
        raise SceneError(f"--workers {options.workers}: give 1 or more")
    options.scene = options.file
    if options.retry_failed and not options.resume:
        raise SceneError("--retry-failed tries again what is in the directory: give --resume, too")
    conclusions, complete, agree = swept(options.file, _results_of(options), options)
    print("\n".join(conclusions))
    if not complete:
        return FAILED
    return DONE if agree else DISAGREE


def _scenes(_: argparse.Namespace) -> int:
    for name in bundled():
        print(f"{name:<18}{Scene.load(name).title}")
    return DONE


COMMANDS = {
    "run": _run,
    "plan": _plan,
    "mesh": _mesh,
    "compare": _compare,
    "study": _study,
    "sweep": _sweep,
    "scenes": _scenes,
}

if __name__ == "__main__":
    raise SystemExit(main())
