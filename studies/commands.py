"""The commands: `ringwear run | check | plan | mesh | compare | study | sweep | ...`.

A command is a public function, and a function here that conducts it: files are named, written and
listed, and texts are printed. Its arguments (`arguments.py`) are the parameters of both.
"""

import atexit
import ctypes
import gc
import re
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from ..meshes import SceneError
from .arguments import in_units
from .crosscheck import (
    Folder,
    Scene,
    UnitNames,
    bundled,
    default_folder,
    named_folder,
    output_folder,
    text_of,
)
from .documented import function_at
from .named_studies import STUDIES
from .report.streams import print_error
from .report.terminal import print_lines, print_markdown, show_progress
from .status import Status
from .tables.writing import INTERRUPTED

# bytes
TRIM_THRESHOLD, MMAP_THRESHOLD = 2**27, 2**25


def conduct(command: str, options: dict[str, Any], usage: str, only: bool) -> Status:
    """Conduct a command; return the exit status.

    Parameters
    ----------
    options : the arguments of its function
    usage : first lines of its help
    only : whether the process ends after the command
    """
    # skip the garbage collection at exit, which takes as long as drawing a figure
    atexit.register(gc.freeze)
    if command != "run":
        # most other commands solve many scenes, whose garbage would fill the memory
        gc.set_threshold(50_000, 50, 50)
    if only and command != "sweep":
        # xarray loads Dask wherever it is installed, and only sweeps need it
        sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
    _keep_freed_memory()
    show_progress(of_stages=command not in ("plan", "study", "sweep"))
    try:
        return function_at(f"commands:_{command}")(**options)
    except SceneError as error:
        error.args = (_possible(str(error), usage),)
        raise


def _keep_freed_memory() -> None:
    """Let glibc keep the memory of freed arrays: the system returns it page by page, which is slow.

    An array of more than `MMAP_THRESHOLD` is not kept, nor is more than `TRIM_THRESHOLD` in all.
    """
    if sys.platform == "linux" and (mallopt := getattr(ctypes.CDLL(None), "mallopt", None)):
        mallopt(-1, TRIM_THRESHOLD)
        mallopt(-3, MMAP_THRESHOLD)


def _possible(message: str, usage: str) -> str:
    """Return a message without remedies by options that a command does not have.

    The remedies of readers name options, and several commands read the same files.
    """
    first, *remedies = re.split(r"(?=; |, by --)", message)
    flag = re.compile(r"--[a-z-]+")
    options = {*flag.findall(usage)}
    # a whole command is in backquotes
    had = (each for each in remedies if {*flag.findall(re.sub("`.*?`", "", each))} <= options)
    return "".join([first, *had])


def _run(
    scene: str = "five_rings",
    *,
    out: str = "",
    no_figures: bool = False,
    no_report: bool = False,
    csv: bool = False,
    verbose: bool = False,
    **given: Any,
) -> Status:
    """Run a scene.

    Parameters
    ----------
    scene : a TOML file, or the name of a bundled scene (default: five_rings)
    no_figures : write numbers only, no figures and no page
    no_report : write figures, but not the page (report.html)
    csv : write the results as CSV tables, too
    verbose : print everything: each ring, every difference, the cost, what is modelled and left out
    """
    from .crosscheck import RUN_FILES, accepted_methods, copies, why_beyond_memory, write_numbers
    from .figures.catalogue import PICTURES
    from .study.own import load_methods

    memory, methods = given.pop("memory", None), load_methods(given.pop("methods", None))
    names = [entry for entry in methods if isinstance(entry, str)] or None
    read = Scene.of(scene, names, **given)
    entries = accepted_methods(read, methods, memory)
    pictures = () if no_figures else PICTURES
    files = {*RUN_FILES, *(picture.file for picture in pictures)}
    # open the folder first, so that a folder that cannot be written to is refused before the work
    with (
        output_folder(_out(out, scene), "run", files) as folder,
        copies(not why_beyond_memory(read, entries.values(), memory, at_once=3)) as apart,
    ):
        from .crosscheck import Account, begun

        complete = begun(read, entries, apart, with_inside=bool(pictures))
        from .report.page import show
        from .report.printed import print_account

        if pictures:
            # while a copy of this process solves by finite elements, load what draws, without the
            # tables in docstrings, which take a third of the time
            import matplotlib.artist

            matplotlib.artist.kwdoc = lambda artist: ""  # noqa: ARG005
            from .figures import states  # noqa: F401

        result = complete()
        account = Account(result)
        page = not (no_figures or no_report)
        # print the answer before anything is written or drawn
        print_account(account, verbose, page)
        write_numbers(result.table, result.summary, folder.hidden, csv)
        failures = show(result, account, pictures, folder.hidden, page)
    return _finish(folder, failures, result.verdict != "disagree" and not result.short_of)


def _out(out: str, name: str, prefix: str = "") -> Path:
    """Return the output folder: that of `--out`, or one that is named after a scene or study."""
    return named_folder(out or default_folder(name, prefix))


def _finish(folder: Folder, failures: Sequence[str] = (), agree: bool = True) -> Status:
    """List the files of a command, and what failed; return the exit status."""
    files = ", ".join(folder.written)
    print_lines(["", f"{len(folder.written)} files in {folder.out}: {files}"])
    for failure in failures:
        print_error(failure)
    return Status.FAILED if failures else Status.DONE if agree else Status.DISAGREE


def _check(
    scene: str,
    theirs: Sequence[str] = (),
    *,
    out: str = "",
    refinement: bool = False,
    **given: Any,
) -> Status:
    """Check results of other programs.

    Parameters
    ----------
    theirs : results of another program: CSV (columns time, radius, pressure, displacement,
        profile, or time, indentation, normal_force), netCDF, or VTU of a half-space
    refinement : treat the files as results of one program from coarse to fine, each with half the
        size of the previous one
    """
    read = Scene.load(scene)
    units = given.get("units")
    names = UnitNames.of(units, read.load_.times_are_distances) if units else None
    given = in_units(read, given, names)
    if not theirs:
        raise SceneError("check compares results of other programs with ours: give their files")
    if repeated := [file for file in theirs if theirs.count(file) > 1]:
        raise SceneError(f"{repeated[0]} is given twice: give each file once")
    others = {Path(file).name: file for file in theirs}
    if len(others) < len(theirs):
        others = {file: file for file in theirs}
    if refinement:
        # in a refinement each size is half of the previous one, unless sizes are given
        given.setdefault("sizes", [0.5**level for level in range(len(others))])
    from .check.check import check, check_files

    with output_folder(_out(out, scene, "check_"), "check", check_files()) as folder:
        found = check(read, others, **given)
        print_lines(["", *found.texts.brief])
        found.write_errors(folder)
        failures = found.write_mistakes(folder)
        print_lines(found.texts.mistakes)
    return _finish(folder, failures, found.passes)


def _fit(scene: str, data: Sequence[str], *, out: str = "", **given: Any) -> Status:
    """Fit parameters.

    Parameters
    ----------
    data : measurements: CSV with columns time, indentation, normal_force; time, radius, profile;
        worn_volume or lost_mass; worn_volume_1 for the first ring from the centre
    """
    from .fit.fit import fit
    from .fit.result import FILES

    read = Scene.load(scene)
    with output_folder(_out(out, scene, "fit_"), "fit", FILES) as folder:
        result = fit(read, data, **given)
        print_lines(["", *repr(result).split("\n")])
        failures = result.write(folder.hidden)
    return _finish(folder, failures, result.fits)


def _plan(scene: str, *, check: bool = False, **given: Any) -> Status:
    """Print the plan of a run, or of the wear steps on a mesh.

    Parameters
    ----------
    check : also condense the finite elements, and report how stable their multipliers are
    """
    from .crosscheck import accepted_methods, beyond_the_model, left_out, modelled, time_scale
    from .report.printed import print_scope
    from .wear_step.plan import plan

    read = Scene.load(scene)
    given = in_units(read, given)
    if given.keys() & {"size", "element", "mesh", "units"}:
        print_lines(["", read.title or "Untitled scene", "", *plan(read, **given)])
        return Status.DONE
    methods = accepted_methods(read, memory=given.get("memory"))
    warnings = [f"warning: {warning}" for warning in beyond_the_model(read)]
    print_lines(["", read.title or "Untitled scene", *time_scale(read), *warnings, ""])
    print_scope(modelled(read, methods), left_out(read, methods))
    print_lines(["", "By method"])
    print_lines(f"  {line}" for line in plan(read, **given))
    if check:
        # it loads matplotlib and pandas, which a plan alone does not need
        from .operators import compare_operators

        # compare the finite elements' multipliers with a compliance that resolves their pressures
        (pair,) = compare_operators(read, ["fem", "mdr"])
        print(
            f"\nMultipliers: inf-sup constant {pair.stability**0.5:.2f}, least ratio of energies "
            f"{pair.stability:.2f} ({pair.methods[0]} over {pair.methods[1]}); over all steady "
            f"states they differ by {pair.rings:.1e}"
        )
    return Status.DONE


def _mesh(scene: str, *, out: str = "") -> Status:
    """Mesh the half-space of a scene, and write it as a VTU file and a figure."""
    read = Scene.load(scene)
    with output_folder(_out(out, scene), "mesh", ["mesh.vtu", "mesh.png"]) as folder:
        from ..meshes import quality
        from .crosscheck import fem_sizes
        from .figures.mesh import write_mesh

        half_space = fem_sizes(read.problem)
        write_mesh(read, half_space.mesh, half_space.mesher, folder.hidden)
    mesh, qualities = half_space.mesh, quality(half_space.mesh)
    kind = "triangles" if len(mesh.t) == 3 else "quadrilaterals"
    print(
        f"{mesh.nelements} {kind} by {half_space.mesher}, {len(mesh.boundaries['contact'])} facets "
        f"on the contact, quality (least sine) {qualities.min():.2f} to {qualities.max():.2f}, "
        f"mean {qualities.mean():.2f}",
        *(f"note: {note}" for note in half_space.notes),
        sep="\n",
    )
    return _finish(folder)


def _compare(a: str, b: str, *, out: str = "") -> Status:
    """Compare two results.

    Parameters
    ----------
    a : a folder that ringwear run has written, a TOML file, or the name of a bundled scene
    b : the same, to be compared with A
    """
    from .comparison import FILES, compare
    from .report.printed import print_table

    with output_folder(_out(out, "compare"), "compare", FILES) as folder:
        comparison = compare(a, b)
        comparison.write(folder.hidden)
    print_lines([f"A: {a}", f"B: {b}"])
    for table in (comparison.scenes, comparison.shown):
        print()
        print_table(table.to_dict("records"))
    print_lines(["", comparison.conclusion])
    if comparison.fields is None:
        print("\ndifference.png is not drawn: no field is given by both at a common time")
    return _finish(folder)


def _study(
    scene: str = "five_rings",
    *,
    study: str,
    out: str = "",
    resume: bool = False,
    **given: Any,
) -> Status:
    """Conduct a study.

    Parameters
    ----------
    scene : a TOML file, or the name of a bundled scene (default: five_rings)
    resume : continue the study in the directory
    """
    from .named_studies import study as conduct_study
    from .study.formats import for_terminal
    from .study.record import as_before, rows_before
    from .study.study import CELLS
    from .tables.writing import keep_tables, keeping_rows

    read, folder_name = Scene.load(scene), _out(out, study)
    given = in_units(read, given)
    setup = {"study": study, "scene": read.to_toml(), "options": given}
    text = rows_before(folder_name, study, setup) if resume else ""
    with output_folder(folder_name, f"study {study}", ["report.html"]) as folder:
        if given.get("quick"):
            print(f"about {STUDIES[study].seconds} s on a machine with two cores", flush=True)
        record = as_before(folder.hidden, study, setup, text)
        results, failures, conclusions = None, list[str](), record.remarks
        with keeping_rows(record.remarks):
            results = conduct_study(study, read, record=record, **given)
        if results is None:
            keep_tables(folder.hidden)
        else:
            conclusions = list(results.conclusions)
            with keeping_rows(conclusions):
                failures += results.write(folder.hidden)
    if results is not None and len(results.answer):
        print_lines(["", f"In each cell: {CELLS}", ""])
        print_markdown(for_terminal(results.answer))
    print_lines(conclusions)
    status = _finish(folder, failures)
    return Status.FAILED if INTERRUPTED in conclusions else status


def _orders(table: str, *, out: str = "", latex: bool = False, **given: Any) -> Status:
    """Fit orders of convergence.

    Parameters
    ----------
    table : a CSV file with one row for each level and one column for each quantity, or the table of
        a study
    latex : print the table in LaTeX instead of Markdown
    """
    from .study.formats import to_latex, to_markdown
    from .study.orders import orders, read_table, right_values, write

    right = right_values(given.pop("right", ()))
    fitted = orders(read_table(table, given["by"]), right=right, **given)
    text = to_latex(fitted) if latex else to_markdown(fitted)
    print_lines(text.splitlines())
    if out:
        with output_folder(out, "orders", ["orders.csv"]) as folder:
            write(fitted, folder.hidden)
        _finish(folder)
    missed = "within" in fitted and (fitted["within"] == "no").any()
    return Status.DISAGREE if missed else Status.DONE


def _sweep(
    file: str,
    *,
    out: str = "",
    scheduler: str = "",
    dry_run: bool = False,
    **given: Any,
) -> Status:
    """Compute a sweep.

    Parameters
    ----------
    file : a sweep file (described in studies/sweep/README.md), or the name of a bundled sweep
    scheduler : the address of a Dask scheduler, to compute on its workers
    dry_run : only print what the sweep will need, by a probe of its first scene
    """
    from .crosscheck import make, refuse_foreign_folders
    from .sweep.axes import Sweep
    from .sweep.blocks import cluster
    from .sweep.sweep import compute, conclusions_of_sweep, estimate

    plan = Sweep.load(file, given.pop("methods", None))
    if dry_run:
        print_lines(estimate(plan, given.get("workers")))
        return Status.DONE
    store = _out(out, file)
    if store.is_dir():
        refuse_foreign_folders(store)
        Folder(store, "sweep").refuse_to_replace(["sweep.png"])
    with cluster(scheduler) if scheduler else nullcontext() as executor:
        dataset = compute(plan, store, executor, **given)
    from .sweep.picture import PICTURE, draw

    with output_folder(store, "sweep", [PICTURE]) as hidden:
        failures = make(hidden.hidden / PICTURE, partial(draw, dataset, plan))
    lines, complete, agree = conclusions_of_sweep(dataset, store)
    print_lines([*lines, *failures])
    if not complete or failures:
        return Status.FAILED
    return Status.DONE if agree else Status.DISAGREE


def _scenes(name: str = "") -> Status:
    """List the bundled scenes, or print one as a start for your own.

    Parameters
    ----------
    name : the name of a bundled scene, to print it
    """
    if name:
        print(text_of(name), end="")
        return Status.DONE
    print_lines(f"{name:<18}{Scene.load(name).title}" for name in bundled())
    return Status.DONE


def _deck(scene: str, *, out: str = "", **given: Any) -> Status:
    """Write decks."""
    from .decks.deck import deck

    read, folder = Scene.load(scene), _out(out, scene, "deck_").resolve()
    files = deck(read, out=folder, **in_units(read, given))
    print_markdown((folder / "README.md").read_text("utf-8").splitlines())
    print_lines(["", f"{len(files)} files in {folder}: {', '.join(file.name for file in files)}"])
    return Status.DONE


def _challenge(words: Sequence[str] = (), *, list: bool = False) -> Status:
    """Compare results of another program with a problem of the wear challenge.

    Without a file, list the problems, or print one as a scene.

    Parameters
    ----------
    words : the problem (its name or number; by default the number in the file's name) and a file
        for ringwear check or, on layered ground, with a table of cases; NAME alone prints the
        problem, no argument lists all problems
    list : list the problems, as without any argument
    """
    from .challenge.problems import problem_name, problem_named, problem_of_file, problems

    match words:
        case [_, *_] if list:
            raise SceneError("challenge --list lists the problems: leave out the name and the file")
        case []:
            for path in problems():
                print_lines(
                    [f"{problem_name(path):<24}{Scene.load(path).title.partition(': ')[2]}"]
                )
        case [word] if not Path(word).is_file():
            print(problem_named(word).read_text("utf-8"), end="")
        case [*names, file] if len(names) < 2:
            from .challenge.answers import submission

            path = problem_named(names[0]) if names else problem_of_file(Path(file))
            print_markdown(submission(path, Path(file)))
        case _:
            raise SceneError("challenge takes a problem and one file: challenge [NAME] FILE")
    return Status.DONE
