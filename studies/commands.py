"""The commands: `ringwear run | check | plan | mesh | compare | study | sweep | ...`."""

import argparse
import atexit
import gc
import shutil
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from .arguments import EXAMPLES, OF_STUDIES, Parser, add_arguments
from .crosscheck import Scene, SceneError, output_folder
from .crosscheck.result.output.folder import Folder, default_folder, named_folder
from .crosscheck.scene.sources import bundled, text_of
from .crosscheck.versions import versions
from .named_studies import STUDIES
from .report.log import show_progress
from .report.streams import print_error
from .report.terminal import print_lines, print_markdown
from .status import Status
from .tables import INTERRUPTED

if TYPE_CHECKING:
    from .figures.style import Picture


def conduct(arguments: list[str] | None) -> Status:
    """Conduct the command of the command line; return the exit status."""
    # skip the garbage collection at exit, which takes as long as drawing a figure
    atexit.register(gc.freeze)
    options = _parser().parse_args(arguments)
    show_progress(of_stages=options.command not in ("plan", "study", "sweep"))
    return COMMANDS[options.command].conduct(options)


def _run(options: argparse.Namespace) -> Status:
    from .crosscheck.result.output.files import run_files, write_numbers

    # collect garbage less often: nearly all objects of a run live to its end, and searching them
    # takes a tenth of the run
    gc.set_threshold(50_000, 50, 50)
    scene = Scene.of(options.scene, options.methods, options.rtol, options.quantities)
    from .crosscheck.result.predictions.memory import refuse_beyond_memory

    refuse_beyond_memory(scene, limit=options.memory)
    pictures: tuple[Picture, ...] = ()
    if not options.no_figures:
        from .figures.catalogue import PICTURES

        pictures = PICTURES
    # open the folder first, so that a folder that cannot be written to is refused before the work
    with output_folder(_out(options, options.scene), "run", run_files(pictures)) as folder:
        from .crosscheck.result.run import run
        from .crosscheck.result.words import Account
        from .report.page import show
        from .report.printed import print_account

        result = run(scene)
        write_numbers(result, folder.hidden, options.csv)
        account = Account(result)
        page = not (options.no_figures or options.no_report)
        # print the answer before drawing the figures
        page = not (options.no_figures or options.no_report)
        print_account(account, options.verbose, page)
        failures = show(result, account, pictures, folder.hidden, page)
    _print_files(folder, failures)
    if failures:
        return Status.FAILED
    return Status.DISAGREE if result.verdict == "disagree" or result.short_of else Status.DONE


def _out(options: argparse.Namespace, name: str, prefix: str = "") -> Path:
    """Return the output folder: that of `--out`, or one that is named after a scene or study."""
    return named_folder(options.out or default_folder(name, prefix))


def _print_files(folder: Folder, failures: list[str]) -> None:
    files = ", ".join(folder.written)
    print_lines(["", f"{len(folder.written)} files in {folder.out}: {files}"])
    for failure in failures:
        print_error(failure)


def _check(options: argparse.Namespace) -> Status:
    from .check.pictures import CHECK_PICTURES
    from .crosscheck.result.output.files import run_files, write_numbers

    scene = Scene.load(options.scene)
    if options.template:
        from .check.template import write_template

        files = {"template.csv", "scene.txt", "unworn.csv", "mesh.msh"}
        with output_folder(options.template, "template", files) as folder:
            print_lines(write_template(scene, options.units, folder.hidden))
        _print_files(folder, [])
        return Status.DONE
    if not options.files:
        raise SceneError(
            "check compares results of other programs with ours: give their files, or --template "
            "DIR to write a table for them to fill in"
        )
    if repeated := [file for file in options.files if options.files.count(file) > 1]:
        raise SceneError(f"{repeated[0]} is given twice: give each file once")
    others = {Path(file).name: file for file in options.files}
    if len(others) < len(options.files):
        others = {file: file for file in options.files}
    # in a refinement each size is half of the previous one, unless sizes are given
    halved_sizes = [0.5**level for level in range(len(others))]
    sizes = options.sizes or (halved_sizes if options.refinement else [])
    out = _out(options, options.scene, "check_")
    files = run_files(CHECK_PICTURES) | {"check.csv"}
    with output_folder(out, "check", files) as folder:
        from .check.account import CheckAccount
        from .check.check import check, write_check
        from .report.page import show

        names = ("within", "columns", "units", "memory")
        settings = {name: getattr(options, name) for name in names}
        result = check(scene, others, sizes=sizes, **settings)
        write_numbers(result, folder.hidden)
        write_check(result, folder.hidden)
        account = CheckAccount(result)
        print_lines(["", *account.brief])
        failures = show(result, account, CHECK_PICTURES, folder.hidden, page=True)
    _print_files(folder, failures)
    if failures:
        return Status.FAILED
    return Status.DONE if result.passes else Status.DISAGREE


def _fit(options: argparse.Namespace) -> Status:
    from .fit.command import conduct

    folder, failures, fits = conduct(options, _out(options, options.scene, "fit_"))
    _print_files(folder, failures)
    if failures:
        return Status.FAILED
    return Status.DONE if fits else Status.DISAGREE


def _plan(options: argparse.Namespace) -> Status:
    from .crosscheck import plan
    from .crosscheck.result.predictions.memory import refuse_beyond_memory
    from .crosscheck.result.run import run
    from .crosscheck.result.scope import (
        beyond_the_model,
        chosen_methods,
        left_out,
        modelled,
        refuse,
        time_scale,
    )
    from .report.printed import print_scope

    scene = Scene.load(options.scene)
    methods = chosen_methods(scene)
    refuse(scene, methods)
    refuse_beyond_memory(scene, methods.values(), options.memory)
    warnings = [f"warning: {warning}" for warning in beyond_the_model(scene)]
    print_lines(["", scene.title or "Untitled scene", *time_scale(scene), *warnings, ""])
    print_scope(modelled(scene, methods), left_out(scene, methods))
    print_lines(["", "By method"])
    print_lines(f"  {line}" for line in plan(scene, options.memory))
    # compare the finite elements' multipliers with a compliance that resolves all their pressures
    for pair in run(scene.changed(methods=["mdr", "fem"])).operators if options.check else ():
        print(
            f"\nMultipliers: inf-sup constant {pair.stability**0.5:.2f}, least ratio of energies "
            f"{pair.stability:.2f} ({pair.methods[0]} over {pair.methods[1]}); over all steady "
            f"states they differ by {pair.rings:.1e}"
        )
    return Status.DONE


def _mesh(options: argparse.Namespace) -> Status:
    scene = Scene.load(options.scene)
    with output_folder(_out(options, options.scene), "mesh", ["mesh.vtu", "mesh.png"]) as folder:
        from ..meshes.half_space import quality
        from .crosscheck.sizes.half_space_mesh import half_space_mesh
        from .figures.mesh import write_mesh

        half_space = half_space_mesh(scene.problem)
        write_mesh(scene, half_space.mesh, half_space.mesher, folder.hidden)
    mesh, qualities = half_space.mesh, quality(half_space.mesh)
    kind = "triangles" if len(mesh.t) == 3 else "quadrilaterals"
    print(
        f"{mesh.nelements} {kind} by {half_space.mesher}, {len(mesh.boundaries['contact'])} facets "
        f"on the contact, quality (least sine) {qualities.min():.2f} to {qualities.max():.2f}, "
        f"mean {qualities.mean():.2f}",
        *(f"note: {note}" for note in half_space.notes),
        sep="\n",
    )
    _print_files(folder, [])
    return Status.DONE


def _compare(options: argparse.Namespace) -> Status:
    from .comparison import FILES, compare
    from .report.printed import print_table

    with output_folder(_out(options, "compare"), "compare", FILES) as folder:
        comparison = compare(options.A, options.B)
        comparison.write(folder.hidden)
    print_lines([f"A: {options.A}", f"B: {options.B}"])
    for table in (comparison.scenes, comparison.shown):
        print()
        print_table(table.to_dict("records"))
    print_lines(["", comparison.verdict_in_words])
    if comparison.fields is None:
        print("\ndifference.png is not drawn: no field is given by both at a common time")
    _print_files(folder, [])
    return Status.DONE


def _study(options: argparse.Namespace) -> Status:
    from .named_studies import study
    from .study.interrupted import as_before, rows_before
    from .tables import keep_tables, keeping_rows

    name, scene = options.study, Scene.load(options.scene)
    out = _out(options, name)
    given = {each: getattr(options, each, None) for each in STUDIES[name].options}
    given = {each: value for each, value in given.items() if value not in (None, [], ())}
    setup = {"study": name, "scene": scene.to_toml(), "quick": options.quick, "options": given}
    text = rows_before(out, name, setup) if options.resume else ""
    with output_folder(out, f"study {name}", ["report.html"]) as folder:
        if options.quick:
            print(f"about {STUDIES[name].seconds} s on a machine with two cores", flush=True)
        record = as_before(folder.hidden, name, setup, text)
        results, failures, conclusions = None, list[str](), record.remarks
        with keeping_rows(record.remarks):
            results = study(name, scene, options.quick, record=record, **given)
        if results is None:
            keep_tables(folder.hidden)
        else:
            conclusions = list(results.conclusions)
            with keeping_rows(conclusions):
                failures += results.write(folder.hidden)
    print_lines(conclusions)
    _print_files(folder, failures)
    return Status.FAILED if failures or INTERRUPTED in conclusions else Status.DONE


def _orders(options: argparse.Namespace) -> Status:
    from .study.formats import to_latex, to_markdown
    from .study.sheet import orders_of_file, write

    table, fitted = orders_of_file(options.table, options.by, options.right, options.tolerance)
    text = to_latex(fitted) if options.latex else to_markdown(fitted)
    print_lines(text.splitlines())
    if options.out:
        with output_folder(options.out, "orders", ["orders.csv", "orders.png"]) as folder:
            write(table, fitted, options.by, folder.hidden)
        _print_files(folder, [])
    missed = "within" in fitted and (fitted["within"] == "no").any()
    return Status.DISAGREE if missed else Status.DONE


def _sweep(options: argparse.Namespace) -> Status:
    from .sweep.conduct import conduct

    if options.workers < 1:
        raise SceneError(f"--workers {options.workers}: give 1 or more")
    out = _out(options, options.file)
    conclusions, complete, agree = conduct(options.file, out, options)
    print_lines(conclusions)
    if not complete:
        return Status.FAILED
    return Status.DONE if agree else Status.DISAGREE


def _scenes(options: argparse.Namespace) -> Status:
    if options.name is not None:
        print(text_of(options.name), end="")
        return Status.DONE
    print_lines(f"{name:<18}{Scene.load(name).title}" for name in bundled())
    return Status.DONE


def _deck(options: argparse.Namespace) -> Status:
    from .decks.deck import Choice, write_decks

    scene = Scene.load(options.scene)
    times = tuple(options.times) if options.times else None
    choice = Choice(options.program, options.elements, options.size, options.reach, times)
    out = options.out or default_folder(options.scene, "deck_")
    with output_folder(out, "deck", ["README.md"]) as folder:
        lines = write_decks(scene, choice, folder.hidden)
    print_markdown(lines)
    print_lines(["", f"{len(folder.written)} files in {out}: {', '.join(folder.written)}"])
    return Status.DONE


def _challenge(options: argparse.Namespace) -> Status:
    """List the problems of the challenge, print one as a scene, or compare results with it."""
    from .challenge.problems import problem_named, problem_of_file, problems

    match options.words:
        case []:
            for path in problems():
                print_lines([f"{path.stem:<24}{Scene.load(path).title.partition(': ')[2]}"])
        case [word] if not Path(word).is_file():
            print(problem_named(word).read_text("utf-8"), end="")
        case [*names, file] if len(names) < 2:
            from .challenge.draw import submission

            path = problem_named(names[0]) if names else problem_of_file(Path(file))
            print_markdown(submission(path, Path(file)))
        case _:
            raise SceneError("challenge takes a problem and one file: challenge [NAME] FILE")
    return Status.DONE


class Command(NamedTuple):
    """A command: line of help, function, names in `ARGUMENTS`, default scene, help examples."""

    help: str
    conduct: Callable[[argparse.Namespace], Status]
    arguments: tuple[str, ...] = ()
    scene: str | None = None
    examples: str | None = None


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
  ringwear challenge                                    list the problems
  ringwear challenge 03_five_rings > mine.toml          print a problem, as a scene
  ringwear challenge 03_five_rings mine.csv             compare your results with it
  ringwear challenge 03_mine.csv                        the same, by the number in the file's name
"""

COMMANDS = {
    "run": Command(
        "compute a scene by every method that it names, and report how far they agree",
        _run,
        (
            *("scene", "--out", "--rtol", "--methods", "--quantities", "--no-figures"),
            *("--no-report", "--csv", "--memory", "--verbose"),
        ),
        "five_rings",
    ),
    "check": Command(
        "compare results of other programs with ours, and report how large their errors are",
        _check,
        (
            *("scene", "files", "--out", "--within", "--columns", "--units", "--refinement"),
            *("--sizes", "--template", "--memory"),
        ),
    ),
    "fit": Command(
        "fit parameters of a scene to measurements, and report how well these determine them",
        _fit,
        (
            *("scene", "data", "--for", "--noise", "--density", "--design", "--columns"),
            *("--units", "--out"),
        ),
    ),
    "plan": Command(
        "print what a scene models and what it will cost",
        _plan,
        ("scene", "--memory", "--check"),
    ),
    "mesh": Command(
        "mesh the half-space of a scene, and write it as a VTU file and a figure",
        _mesh,
        ("scene", "--out"),
    ),
    "compare": Command(
        "compare two folders of results, or two scenes, and draw them together",
        _compare,
        ("A", "B", "--out"),
    ),
    "study": Command("conduct a study: write figures and tables, and print conclusions", _study),
    "orders": Command(
        "fit orders of convergence to a table of levels, and print them with their intervals",
        _orders,
        ("table", "--by", "--right", "--tolerance", "--latex", "--out"),
        None,
        ORDERS_EXAMPLES,
    ),
    "sweep": Command(
        "compute many scenes over axes of scene keys, and write them to one store",
        _sweep,
        (
            *("file", "--out", "--scheduler", "--workers", "--memory", "--dry-run", "--resume"),
            "--retry-failed",
        ),
    ),
    "scenes": Command(
        "list the bundled scenes, or print one as a start for your own", _scenes, ("name",)
    ),
    "deck": Command(
        "write input files of a scene for CalculiX or Abaqus, and a README that explains them",
        _deck,
        ("scene", "--for PROGRAM", "--elements", "--size", "--reach", "--time", "--out"),
        None,
        DECK_EXAMPLES,
    ),
    "challenge": Command(
        "compare results of another program with a problem of the wear challenge",
        _challenge,
        ("words",),
        None,
        CHALLENGE_EXAMPLES,
    ),
}


PURPOSE = (
    "Compute how a rigid punch of concentric rings wears on an elastic half-space, by finite "
    "elements, dimensionality reduction, boundary elements and direct integration, and report how "
    "far these methods agree."
)


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="ringwear",
        description=textwrap.fill(PURPOSE, shutil.get_terminal_size().columns - 2),
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"ringwear {versions()['ringwear']}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")
    for name, command in COMMANDS.items():
        formatter, examples = argparse.RawDescriptionHelpFormatter, command.examples
        subparser = commands.add_parser(
            name, help=command.help, epilog=examples, formatter_class=formatter
        )
        add_arguments(subparser, command.arguments, command.scene)
        if name == "study":
            names = subparser.add_subparsers(required=True, metavar="NAME", dest="study")
            for study, row in STUDIES.items():
                subparser = names.add_parser(study, help=row.purpose)
                add_arguments(subparser, ("scene", "--out", "--quick", "--resume"), row.scene)
                for option in row.options:
                    for flag, settings in OF_STUDIES.get(option, ()):
                        subparser.add_argument(flag, dest=option, **settings)
    return parser
