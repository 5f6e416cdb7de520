"""The commands: `ringwear run | check | plan | mesh | compare | study | sweep | ...`.

A command is a public function: its flags are the parameters of the function, and its help is the
docstring. Here is what the command line adds: files are named, written and listed, and texts are
printed.
"""

import argparse
import atexit
import gc
import shutil
import sys
import textwrap
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..meshes import SceneError
from .arguments import FLAGS, add_arguments, flag_of, new_parser
from .crosscheck import (
    Folder,
    Scene,
    bundled,
    default_folder,
    named_folder,
    output_folder,
    package_versions,
    text_of,
)
from .documented import documented
from .named_studies import STUDIES
from .report.log import show_progress
from .report.streams import print_error
from .report.terminal import print_lines, print_markdown
from .status import Status
from .tables.writing import INTERRUPTED

if TYPE_CHECKING:
    from .figures.style import Picture


def conduct(arguments: list[str] | None) -> Status:
    """Conduct the command of the command line; return the exit status."""
    # skip the garbage collection at exit, which takes as long as drawing a figure
    atexit.register(gc.freeze)
    options = _read(sys.argv[1:] if arguments is None else arguments)
    if arguments is None and options.command != "sweep":
        # xarray loads Dask wherever it is installed, and only sweeps need it
        sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
    show_progress(of_stages=options.command not in ("plan", "study", "sweep"))
    return COMMANDS[options.command].conduct(options)


def _run(options: argparse.Namespace) -> Status:
    from .crosscheck import RUN_FILES, write_numbers

    # collect garbage less often: nearly all objects of a run live to its end, and searching them
    # takes a tenth of the run
    gc.set_threshold(50_000, 50, 50)
    from .crosscheck import refuse_beyond_memory
    from .study.own import load_methods

    methods = load_methods(options.methods)
    names = [entry for entry in methods if isinstance(entry, str)] or None
    scene = Scene.of(options.scene, names, options.rtol, options.quantities)

    refuse_beyond_memory(scene, limit=options.memory)
    pictures: tuple[Picture, ...] = ()
    if not options.no_figures:
        from .figures.catalogue import PICTURES

        pictures = PICTURES
    files = {*RUN_FILES, *(picture.file for picture in pictures)}
    # open the folder first, so that a folder that cannot be written to is refused before the work
    with output_folder(_out(options, options.scene), "run", files) as folder:
        from .crosscheck import Account, run
        from .report.page import show
        from .report.printed import print_account

        result = run(scene, methods=methods or None, memory=options.memory)
        write_numbers(result.dataset, result.summary, folder.hidden, options.csv)
        account = Account(result)
        page = not (options.no_figures or options.no_report)
        # print the answer before drawing the figures
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
    scene = Scene.load(options.scene)
    if not options.theirs:
        raise SceneError("check compares results of other programs with ours: give their files")
    if repeated := [file for file in options.theirs if options.theirs.count(file) > 1]:
        raise SceneError(f"{repeated[0]} is given twice: give each file once")
    others = {Path(file).name: file for file in options.theirs}
    if len(others) < len(options.theirs):
        others = {file: file for file in options.theirs}
    # in a refinement each size is half of the previous one, unless sizes are given
    halved_sizes = [0.5**level for level in range(len(others))]
    sizes = options.sizes or (halved_sizes if options.refinement else [])
    from .check.check import check, check_files

    with output_folder(_out(options, options.scene, "check_"), "check", check_files()) as folder:
        given = _given(options, "check") | {"sizes": sizes}
        found = check(scene, others, **given)
        print_lines(["", *found.texts.brief])
        found.write_errors(folder)
        failures = found.write_mistakes(folder)
        print_lines(found.texts.mistakes)
    _print_files(folder, failures)
    if failures:
        return Status.FAILED
    return Status.DONE if found.passes else Status.DISAGREE


def _fit(options: argparse.Namespace) -> Status:
    from .fit.fit import fit
    from .fit.result import FILES

    scene = Scene.load(options.scene)
    with output_folder(_out(options, options.scene, "fit_"), "fit", FILES) as folder:
        result = fit(scene, options.data, options.parameters, **_given(options, "fit"))
        print_lines(["", *repr(result).split("\n")])
        failures = result.write(folder.hidden)
    _print_files(folder, failures)
    if failures:
        return Status.FAILED
    return Status.DONE if result.fits else Status.DISAGREE


def _plan(options: argparse.Namespace) -> Status:
    from .crosscheck import (
        beyond_the_model,
        chosen_methods,
        left_out,
        modelled,
        refuse,
        refuse_beyond_memory,
        run,
        time_scale,
    )
    from .report.printed import print_scope
    from .wear_step.plan import plan

    scene, given = Scene.load(options.scene), _given(options, "plan")
    if given.keys() & {"size", "element", "mesh"}:
        print_lines(["", scene.title or "Untitled scene", "", *plan(scene, **given)])
        return Status.DONE
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
    """Mesh the half-space of a scene, and write it as a VTU file and a figure."""
    scene = Scene.load(options.scene)
    with output_folder(_out(options, options.scene), "mesh", ["mesh.vtu", "mesh.png"]) as folder:
        from ..meshes import quality
        from .crosscheck import fem_sizes
        from .figures.mesh import write_mesh

        half_space = fem_sizes(scene.problem)
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
        comparison = compare(options.a, options.b)
        comparison.write(folder.hidden)
    print_lines([f"A: {options.a}", f"B: {options.b}"])
    for table in (comparison.scenes, comparison.shown):
        print()
        print_table(table.to_dict("records"))
    print_lines(["", comparison.conclusion])
    if comparison.fields is None:
        print("\ndifference.png is not drawn: no field is given by both at a common time")
    _print_files(folder, [])
    return Status.DONE


def _study(options: argparse.Namespace) -> Status:
    from .named_studies import study
    from .study.formats import for_terminal
    from .study.interrupted import as_before, rows_before
    from .tables.writing import keep_tables, keeping_rows

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
    if results is not None and len(results.answer):
        print_markdown(for_terminal(results.answer))
    print_lines(conclusions)
    _print_files(folder, failures)
    return Status.FAILED if failures or INTERRUPTED in conclusions else Status.DONE


def _orders(options: argparse.Namespace) -> Status:
    from .study.formats import to_latex, to_markdown
    from .study.sheet import orders_of_file, write

    table, fitted = orders_of_file(
        options.table, options.by, options.right or [], options.tolerance
    )
    text = to_latex(fitted) if options.latex else to_markdown(fitted)
    print_lines(text.splitlines())
    if options.out:
        with output_folder(options.out, "orders", ["orders.csv", "orders.png"]) as folder:
            write(table, fitted, options.by, folder.hidden)
        _print_files(folder, [])
    missed = "within" in fitted and (fitted["within"] == "no").any()
    return Status.DISAGREE if missed else Status.DONE


def _sweep(options: argparse.Namespace) -> Status:
    from .crosscheck import make, refuse_foreign_folders
    from .sweep.axes import Sweep
    from .sweep.blocks import cluster
    from .sweep.sweep import compute, estimate
    from .sweep.words import conclude

    plan = Sweep.load(options.file, options.methods and list(options.methods))
    if options.dry_run:
        print_lines(estimate(plan, options.workers))
        return Status.DONE
    out = _out(options, options.file)
    if out.is_dir():
        refuse_foreign_folders(out)
        Folder(out, "sweep").refuse_to_replace(["sweep.png"])
    with cluster(options.scheduler) if options.scheduler else nullcontext() as executor:
        given = _given(options, "sweep")
        dataset = compute(plan, out, executor, **given)
    from .sweep.picture import PICTURE, draw

    with output_folder(out, "sweep", [PICTURE]) as hidden:
        failures = make(hidden.hidden / PICTURE, partial(draw, dataset, plan))
    lines, complete, agree = conclude(dataset, out)
    print_lines([*lines, *failures])
    if not complete or failures:
        return Status.FAILED
    return Status.DONE if agree else Status.DISAGREE


def _scenes(options: argparse.Namespace) -> Status:
    """List the bundled scenes, or print one as a start for your own."""
    if options.name is not None:
        print(text_of(options.name), end="")
        return Status.DONE
    print_lines(f"{name:<18}{Scene.load(name).title}" for name in bundled())
    return Status.DONE


def _deck(options: argparse.Namespace) -> Status:
    from .decks.deck import choose, write_decks

    scene = Scene.load(options.scene)
    choice = choose(scene, options.program, **_given(options, "deck"))
    out = options.out or default_folder(options.scene, "deck_")
    with output_folder(out, "deck", ["README.md"]) as folder:
        lines = write_decks(scene, choice, folder.hidden)
    print_markdown(lines)
    print_lines(["", f"{len(folder.written)} files in {out}: {', '.join(folder.written)}"])
    return Status.DONE


def _challenge(options: argparse.Namespace) -> Status:
    """Compare results of another program with a problem of the wear challenge.

    Without a file, list the problems, or print one as a scene.
    """
    from .challenge.problems import name_of, problem_named, problem_of_file, problems

    match options.words:
        case [_, *_] if options.list:
            raise SceneError("challenge --list lists the problems: leave out the name and the file")
        case []:
            for path in problems():
                print_lines([f"{name_of(path):<24}{Scene.load(path).title.partition(': ')[2]}"])
        case [word] if not Path(word).is_file():
            print(problem_named(word).read_text("utf-8"), end="")
        case [*names, file] if len(names) < 2:
            from .challenge.submission import submission

            path = problem_named(names[0]) if names else problem_of_file(Path(file))
            print_markdown(submission(path, Path(file)))
        case _:
            raise SceneError("challenge takes a problem and one file: challenge [NAME] FILE")
    return Status.DONE


def _given(options: argparse.Namespace, command: str) -> dict[str, Any]:
    """Return the flags of a command that are parameters of its function, by their names."""
    command_ = COMMANDS[command]
    parameters = documented(command_.place).parameters
    names = parameters.keys() & {*command_.arguments} - {*command_.named}
    given = {name: getattr(options, name) for name in names}
    return {name: value for name, value in given.items() if value is not None}


class Command(NamedTuple):
    """A command.

    Parameters
    ----------
    place : the function whose docstring is the help, as in `documented`
    conduct : conducts the command
    arguments : parameters of the function, arguments without a flag, and flags of the command
    named : arguments that `conduct` passes to the function by itself
    defaults : values on the command line that differ from those of the function
    examples : text at the end of the help
    """

    place: str
    conduct: Callable[[argparse.Namespace], Status]
    arguments: tuple[str, ...]
    named: tuple[str, ...] = ("scene",)
    defaults: dict[str, object] = {}  # noqa: RUF012
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
    "run": Command(
        "crosscheck.result.run:run",
        _run,
        (
            *("scene", "--out", "rtol", "methods", "quantities", "--no-figures", "--no-report"),
            *("--csv", "memory", "--verbose"),
        ),
        defaults={"scene": "five_rings"},
    ),
    "check": Command(
        "check.check:check",
        _check,
        (
            *("scene", "theirs", "--out", "methods", "within", "columns", "units", "sizes"),
            *("times", "--refinement", "element", "memory"),
        ),
        ("scene", "theirs", "sizes"),
    ),
    "fit": Command(
        "fit.fit:fit",
        _fit,
        (
            *("scene", "data", "parameters", "noise", "density"),
            *("columns", "units", "cycle", "--out"),
        ),
        ("scene", "data", "parameters"),
    ),
    "plan": Command(
        "wear_step.plan:plan",
        _plan,
        ("scene", "memory", "size", "mesh", "element", "--check"),
    ),
    "mesh": Command("commands:_mesh", _mesh, ("scene", "--out")),
    "compare": Command("comparison:compare", _compare, ("a", "b", "--out")),
    "study": Command("named_studies:study", _study, ()),
    "orders": Command(
        "study.orders:orders",
        _orders,
        ("table", "by", "right", "tolerance", "--latex", "--out"),
        examples=ORDERS_EXAMPLES,
    ),
    "sweep": Command(
        "sweep.sweep:sweep",
        _sweep,
        (
            *("file", "--out", "methods", "workers", "--scheduler", "--dry-run"),
            *("resume", "retry_failed"),
        ),
        ("file", "methods"),
    ),
    "scenes": Command("commands:_scenes", _scenes, ("name",)),
    "deck": Command(
        "decks.deck:deck",
        _deck,
        ("scene", "program", "element", "size", "reach", "times", "--out"),
        ("scene", "program"),
        examples=DECK_EXAMPLES,
    ),
    "challenge": Command(
        "commands:_challenge", _challenge, ("words", "--list"), examples=CHALLENGE_EXAMPLES
    ),
}


PURPOSE = (
    "Compute how a rigid punch of concentric rings wears on an elastic half-space, by finite "
    "elements, dimensionality reduction, boundary elements and direct integration, and report how "
    "far these methods agree."
)


def _read(arguments: list[str]) -> argparse.Namespace:
    """Read the arguments of the command line."""
    width = shutil.get_terminal_size().columns - 2
    parser = new_parser("ringwear", textwrap.fill(PURPOSE, width), EXAMPLES)
    version = f"ringwear {package_versions()['ringwear']}"
    parser.add_argument("--version", action="version", version=version)
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")
    called = next(iter(arguments), "")
    for name, command in COMMANDS.items():
        # the sources of other commands are not read if one is called
        if called in COMMANDS and called != name:
            commands.add_parser(name)
            continue
        subparser = commands.add_parser(
            name,
            help=documented(command.place).purpose,
            description=textwrap.fill(documented(command.place).purpose, width),
            epilog=command.examples,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        add_arguments(subparser, command.place, command.arguments, command.defaults)
        if name == "study":
            names = subparser.add_subparsers(required=True, metavar="NAME", dest="study")
            for study, row in STUDIES.items():
                subparser = names.add_parser(study, help=row.purpose, description=row.purpose)
                options = (each for each in row.options if flag_of(each) in FLAGS)
                flags = ["scene", "--out", "quick", "--resume", *options]
                flags += ["--quantity"] * ("quantities" in row.options)
                add_arguments(subparser, row.place, flags, {"scene": row.scene})
    return parser.parse_args(arguments)
