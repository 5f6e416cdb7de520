"""Compare results of other programs with ours.

The scene is solved at the times and radii of the other programs, so that nothing is interpolated.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...meshes import RingwearError, SceneError
from ..crosscheck import (
    FIELDS,
    LOG,
    METHODS,
    OVER_TIME,
    RUN_FILES,
    AnswersGuesses,
    Folder,
    Problem,
    Result,
    Results,
    Scene,
    Solution,
    Source,
    Stages,
    begun,
    chosen_methods,
    listed,
    methods_of,
    naming_arguments,
    numbers,
    output_folder,
    refuse,
    refuse_beyond_memory,
    shown,
    why_beyond_memory,
    with_others,
    write_numbers,
)
from ..decks.reports import reach_of_deck
from ..estimate.compared import PRINTED, Comparison
from ..estimate.diagnose import diagnose
from ..estimate.diagnosis import EXPLAINS, REDUCES, Diagnosis
from ..estimate.model import unit_of
from ..study.own import element_named
from ..tables.writing import as_json, write_csv
from .errors import ErrorAtTime, best, errors_at_times
from .other_program import OtherProgram
from .refinement import Refinement, order_in_words, refinements
from .sawtooth import mistake_of_steps
from .tables import NoTimesError, OthersResults, are_steps, by_name, read, without_number

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.figure import Figure

    from ..figures.catalogue import Picture
    from .account import CheckAccount

# Copies of the fields of another program that are in memory at once, with their differences to
# ours; and numbers that the errors of one quantity at one time take, with their texts. Measured.
COPIES_OF_FIELDS, NUMBERS_OF_ERRORS = 8.0, 250.0


@naming_arguments
def check(
    scene: Source,
    theirs: "Mapping[str, OthersResults] | OthersResults",
    methods: Sequence[str] | str | None = None,
    within: float = 0.01,
    columns: Mapping[str, str] | None = None,
    units: str = "",
    sizes: Sequence[float] = (),
    times: Sequence[float] = (),
    element: str | None = None,
    memory: float | None = None,
) -> "Check":
    """Compare results of other programs with ours, at their times and radii.

    Parameters
    ----------
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries
    theirs : results of other programs: CSV or netCDF files, DataFrames or xarray Datasets, by the
        names of the programs; or a single one, which is named after its file, or "theirs"
    methods : methods of ringwear, instead of the scene's
    within : allowed relative error of their results, in the norm of each quantity
    columns : our names by theirs, ``{"p": "pressure"}``
    units : of their results, such as ``"mm, N, MPa, s"``, if they differ from the scene's
    sizes : decreasing sizes of elements or steps, one for each result, if the results are those of
        one program from coarse to fine; only the last one is judged then
    times : time of results that have no column of times; if there are several, each file has the
        results of one program at one of them
    element : elements of the other programs, P1, P2, Q1, Q2 or Q2S, if they are known: with them
        the longest wear step that a mesh allows is told more accurately
    memory : largest memory to use, in GiB; by default that of the machine

    Returns
    -------
    Check
        With `result` (ours), `theirs`, `errors`, `within`, `passes` and `mistakes()`, which tries
        mistakes that may explain the errors.

    Raises
    ------
    SceneError
        if a table cannot be read; the message names the file, the line, the column and the remedy.
        If a program has the name of one of our methods, or if the sizes do not suit the results.
        If there are so many times and radii that memory does not suffice, it says how many fit

    Examples
    --------
    >>> from pandas import DataFrame
    >>> table = DataFrame({"time": [0.0], "indentation": [0.97]})
    >>> checked = check("flat_punch", {"abaqus": table}, methods=["mdr"])
    >>> float(checked.errors.error[0].round(4)), checked.passes
    (-0.03, False)
    """
    if not (isinstance(within, float | int) and within > 0):
        raise SceneError(f"within = {shown(within)}: give a positive number, such as 0.01")
    element = None if element is None else element_named(element)
    # one file is named without its folder
    given = {Path(theirs).name: theirs} if isinstance(theirs, str | Path) else theirs
    remedy = (
        "give a file, a DataFrame, a Dataset, or these by the names of their programs, such as "
        "{'abaqus': 'abaqus.csv'}"
    )
    programs, sizes = by_name(given, "theirs", remedy), tuple(numbers("sizes", sizes))
    scene = Scene.of(scene)
    if taken_names := [name for name in programs if name in METHODS]:
        raise SceneError(
            f"{taken_names[0]} is one of our methods: give the other program another name"
        )
    decreasing = len(sizes) > 1 and (np.diff([*sizes, 0.0]) < 0).all()
    if sizes and not (decreasing and len(sizes) == len(programs)):
        raise SceneError(
            f"sizes {', '.join(f'{size:g}' for size in sizes)} of {len(programs)} results: give "
            "two or more results, and a size for each, above 0 and decreasing"
        )
    of_steps = tuple(numbers("times", times))
    tables = _read_all(programs, scene, columns or {}, units, of_steps)
    scene = _scene_of_tables(scene, tables.values())
    ours = methods_of(listed(methods)) if methods else chosen_methods(scene)
    refuse(scene, ours)
    if not methods:
        # mdr-grid is the paper's own algorithm, of first order: too inaccurate for a reference
        accurate = {name: entry for name, entry in ours.items() if name != "mdr-grid"}
        ours = accurate or methods_of(["mdr", "fem"])
    names = [name for table in tables.values() for name in table]
    fields = [name for name in names if name in FIELDS]
    numbers_of_fields = COPIES_OF_FIELDS * len(fields) * len(scene.problem.radii)
    numbers_at_a_time = numbers_of_fields + NUMBERS_OF_ERRORS * len(names)
    # our own fields are shown, but not needed to check numbers
    if not fields and why_beyond_memory(scene, ours.values(), memory, numbers_at_a_time):
        LOG.warning(
            "%d times are too many for fields: ours are left out, because the results have none",
            len(scene.wear.times),
        )
        scene = scene.changed(output__quantities=["history", "steady"])
    refuse_beyond_memory(scene, ours.values(), memory, numbers_at_a_time)
    others = {name: OtherProgram.from_table(name, table, scene) for name, table in tables.items()}
    methods_of([*others.values()])  # refuses names that are more than one line
    decks = {name: reach_of_deck(programs.get(name), scene) for name in tables}
    return Check(begun(scene, ours)(), others, within, sizes, decks, element)


@dataclass(frozen=True, eq=False, repr=False)
class Check(AnswersGuesses):
    """Results of other programs and ours, and the errors of theirs.

    Parameters
    ----------
    result : our result, at their times and radii
    others : the other programs by their names
    within : relative error that is allowed
    sizes : of elements or steps, if all results are of one program, from coarse to fine, so that
        only the last one is judged; otherwise empty
    decks : radius of the half-space, in punch radii, of results of decks of this scene by
        `ringwear deck`, by the name of the results; None of other results
    element : elements of the other programs; None if they are not known
    """

    result: Result
    others: Mapping[str, OtherProgram]
    within: float
    sizes: tuple[float, ...] = ()
    decks: Mapping[str, float | None] = field(default_factory=dict)
    element: str | None = None

    @property
    def scene(self) -> Scene:
        """The scene, at their times and radii."""
        return self.result.scene

    @property
    def theirs(self) -> "xarray.Dataset":
        """Their results over solver, time and radius, in the scene's units, where they have any."""
        dataset = self.together.dataset.sel(solver=[*self.others])
        return dataset[[name for name in dataset if dataset[name].notnull().any()]]

    @cached_property
    def errors(self) -> "pd.DataFrame":
        """A row for each program, quantity and time.

        The columns `error`, `stated` (our own error estimate), `radius`, `there` and `largest` are
        those of `ErrorAtTime` in `studies/check/errors.py`; `within` is whether the error is within
        the allowed one or our own error estimate.
        """
        import pandas as pd

        return pd.DataFrame([asdict(row) for row in self.rows])

    @property
    def passes(self) -> bool:
        """Whether judged results are within the allowed error, and our methods do not disagree."""
        return all(map(self.is_within, self.judged)) and self.result.verdict != "disagree"

    def mistakes(self, program: str | None = None) -> list[Diagnosis]:
        """Try mistakes that may explain the errors, and return these, the likeliest first.

        Each has `words`, which say whether it explains the differences, and what to do next. If no
        mistake that is known does, the only entry says so, where the errors are greatest, and what
        to do. This takes seconds, because mistakes are tried by solving changed scenes; they are
        computed once.

        Parameters
        ----------
        program : whose errors are to be explained; by default those of all judged results
        """
        names = self.judged if program is None else (program,)
        for name in names:
            if name not in self._mistakes:
                found = self._mistakes_of(name)
                self._mistakes[name] = [replace(each, program=name) for each in found]
        mistakes = [mistake for name in names for mistake in self._mistakes[name]]
        return sorted(mistakes, key=lambda mistake: -mistake.share)

    def _mistakes_of(self, program: str) -> list[Diagnosis]:
        """Try mistakes that may explain the errors of a program.

        A sawtooth of pressures hides all other mistakes that do not change indentation or force.
        """
        LOG.info("   check  trying mistakes that may explain the errors of %s ...", program)
        rows, compared = self.rows_of(program), self.compared(program)
        first = mistake_of_steps(compared, rows, self.within, self.element)
        if first and first[0].judgement == EXPLAINS:
            return first
        if self.refinements and not self.is_within(program):
            first += self._error_of_mesh()
        compared = replace(compared, mesh_results=self._results_on_mesh(compared))
        others = diagnose(compared, self.decks.get(program))
        nothing_explains = not first and all(each.judgement == REDUCES for each in others)
        if nothing_explains and rows and not self.is_within(program):
            others.append(Diagnosis(confirm=self.texts.next_step(program), share=0.0))
        return first + others

    def _error_of_mesh(self) -> list[Diagnosis]:
        """Return the diagnosis of the mesh if all results of a refinement converge to ours.

        Fields count only if there are no numbers: their errors at the rim and at ring edges stay.
        """
        counted = [each for each in self.refinements if each.counted.all()]
        counted = [each for each in counted if each.quantity not in FIELDS] or counted
        if not counted or not all(each.converges for each in counted):
            return []
        worst = max(counted, key=lambda each: float(each.errors[-1]))
        error, order, sizes = float(worst.errors[-1]), worst.order, worst.sizes
        looks_like = (
            "errors of the mesh or of the steps, which decrease with their size: "
            f"{worst.label(self.scene.unit_names)} by order {order_in_words(order)}"
        )
        # what remains if the size is reduced once more
        remaining = error * float(sizes[-1] / sizes[-2]) ** order
        confirm = "reduce the size once more: the errors decrease as before"
        size = float(sizes[-1])
        return [Diagnosis("mesh", size, EXPLAINS, looks_like, error, remaining, confirm)]

    @cached_property
    def _mistakes(self) -> dict[str, list[Diagnosis]]:
        """The mistakes that were found so far, by program."""
        return {}

    @cached_property
    def together(self) -> Result:
        """Our result with theirs beside it, for figures and for `results.nc`."""
        problem = self.scene.problem
        theirs = {name: each.solve(problem, Stages(name)) for name, each in self.others.items()}
        compared = self._compared_in_fields(theirs)
        return replace(with_others(self.result, self.others, theirs), compared_in_fields=compared)

    def _compared_in_fields(self, theirs: Mapping[str, Solution]) -> tuple[str, ...]:
        """Return our most accurate method, then judged programs with fields, the last one first.

        Empty if no program has fields.
        """
        fields = {
            name: [each for each in OVER_TIME if each in theirs[name].results]
            for name in reversed(self.judged)
        }
        names = [name for name in fields if fields[name]]
        ours = best(self._our_solutions, fields[names[0]][0]) if names else ""
        return (ours, *names) if ours else ()

    @cached_property
    def _our_solutions(self) -> dict[str, Solution]:
        """Our solutions; a prescribed force has an error of 0."""
        problem, solutions = self.scene.problem, self.result.solutions
        return {
            name: _with_prescribed_force(problem, solution) for name, solution in solutions.items()
        }

    @cached_property
    def rows(self) -> tuple[ErrorAtTime, ...]:
        """Errors of the other programs, by program, quantity and time."""
        reference = "".join(self.together.compared_in_fields[:1])
        return tuple(
            row
            for name in self.others
            for row in errors_at_times(
                self.scene,
                self._our_solutions,
                (name, self.together.solutions[name].results),
                self.within,
                reference,
            )
        )

    def rows_of(self, program: str) -> list[ErrorAtTime]:
        """Return the errors of a program."""
        return [row for row in self.rows if row.solver == program]

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of the results that are judged: all, or the finest of a refinement."""
        return tuple(self.others)[-1:] if self.sizes else tuple(self.others)

    def is_within(self, program: str) -> bool:
        """Return whether all results of a program are within the allowed error.

        Those that cannot be compared do not count, but at least one must be compared.
        """
        rows = self.rows_of(program)
        return bool(rows) and all(row.within for row in rows)

    def undecided_on(self, program: str) -> list[str]:
        """Return the quantities whose errors are above the allowed one, but within our estimate."""
        rows = (row for row in self.rows_of(program) if row.within)
        return [*dict.fromkeys(row.quantity for row in rows if abs(row.error) > self.within)]

    @cached_property
    def refinements(self) -> tuple[Refinement, ...]:
        """Convergence of each quantity, if the results are a refinement."""
        return tuple(refinements(self.rows, tuple(self.others), self.sizes)) if self.sizes else ()

    def compared(self, program: str) -> Comparison:
        """Return the results of a program, and ours at its times and radii.

        Quantities on which mistakes have no known effect are left out.
        """
        together = self.together
        printed = [key for key in together.solutions[program].results if key in PRINTED]
        dataset = together.dataset[printed].sel(solver=program)
        for dim in list(dataset.dims):
            dataset = dataset.dropna(dim, how="all")
        theirs = {str(key): array.values for key, array in dataset.items()}
        ours = {
            key: together.dataset[key]
            .sel(solver=best(self._our_solutions, key))
            .reindex_like(dataset[key])
            .values
            for key in theirs
            if best(self._our_solutions, key)
        }
        times, radii = dataset["time"].values, np.asarray(dataset.get("radius", np.empty(0)))
        return Comparison(times, radii, theirs, ours, self.scene)

    def _results_on_mesh(self, compared: Comparison) -> Results:
        """Return results of a mesh with nodes at the radii; empty if there is no such mesh."""
        if compared.pressures is None:
            return {}
        # it loads scikit-fem, which tables without an error do not need
        from ..wear_step.models import results_on_mesh

        problem = self.scene.problem
        found = results_on_mesh(problem, *compared.pressures, self.element or "P1")
        return {name: values * unit_of(problem.units, name) for name, values in found.items()}

    @property
    def summary(self) -> dict[str, Any]:
        """The summary of our result, and the errors of theirs, as in `summary.json`.

        There it also has the mistakes that may explain these errors.
        """
        check = {"passes": self.passes, "within": self.within, "lines": self.texts.lines}
        errors: list[dict[str, Any]] = as_json([asdict(row) for row in self.rows])
        return self.together.summary | {"check": check, "errors": errors}

    @property
    def texts(self) -> "CheckAccount":
        """All texts about their results, and about ours."""
        from .account import CheckAccount

        return CheckAccount(self)

    def __repr__(self) -> str:
        """Return the errors of their results, and the verdict on ours."""
        return "\n".join(self.texts.brief)

    def _repr_html_(self) -> str:
        """Return the errors, the verdict and one figure as HTML, for notebooks."""
        from ..figures.style import html_of

        text = f"<pre>{escape(repr(self))}</pre>"
        return text + html_of(self.plot()) if self.plots else text

    @property
    def pictures(self) -> "list[Picture]":
        """The figures that can be drawn, those that show their results first."""
        from .pictures import pictures

        return [picture for picture in pictures(self) if picture.drawn_for(self.together)]

    @property
    def plots(self) -> tuple[str, ...]:
        """The figures that `plot` can draw."""
        return tuple(picture.name for picture in self.pictures)

    def plot(self, kind: str = "") -> "Figure":
        """Draw a figure: one of `plots`, by default the first.

        Raises
        ------
        SceneError
            if there is no such figure; the message lists the available ones
        """
        from ..figures.catalogue import picture_of

        return picture_of(self.pictures, kind).figure(self.together)

    def save(self, folder: str | Path) -> list[str]:
        """Write the files of ``ringwear check --out folder``; return their names.

        Errors are saved before mistakes are tried.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or contains other files with these names
        RingwearError
            if a figure cannot be drawn
        """
        with output_folder(folder, "check", check_files()) as out:
            self.write_errors(out)
            if failures := self.write_mistakes(out):
                raise RingwearError("; ".join(failures))
        return out.written

    def write_errors(self, folder: Folder) -> None:
        """Write all numbers, and put them in place before anything else is computed."""
        self._write_numbers(folder, self.summary)
        folder.publish_so_far()

    def write_mistakes(self, folder: Folder) -> list[str]:
        """Try mistakes; write them, the figures and the page; return the failures, with reasons."""
        from ..report.page import show

        mistakes, account = self.mistakes(), self.texts
        check = {"lines": [*account.lines, *account.mistakes]}
        summary = self.summary
        summary["check"] |= check
        rows = [asdict(each) | {"words": each.words} for each in mistakes]
        self._write_numbers(folder, summary | {"mistakes": rows})
        return show(self.together, account, self.pictures, folder.hidden, page=True)

    def _write_numbers(self, folder: Folder, summary: dict[str, Any]) -> None:
        write_numbers(self.together.table, summary, folder.hidden)
        write_csv(self.errors, folder.hidden / "check.csv")


def check_files() -> set[str]:
    """Return the names of the files that a check may write."""
    from .pictures import FILES

    return {*RUN_FILES, "check.csv", *FILES}


def _read_all(
    programs: "Mapping[str, OthersResults]",
    scene: Scene,
    columns: Mapping[str, str],
    units: str,
    times: Sequence[float],
) -> "dict[str, pd.DataFrame]":
    """Return the tables of programs by their names; files of the steps of one program are joined.

    Parameters
    ----------
    programs : results by the names of programs, or of files
    scene, columns, units : see `check`
    times : none; the time of all; or one for each file of one program

    Raises
    ------
    SceneError
        if a table cannot be read, or if there are not as many times as files
    """
    if len(times) > 1 and len(times) != len(programs):
        raise SceneError(
            f"{len(times)} times and {len(programs)} results: give one time for each file of one "
            "program, or one time for all"
        )
    if len(times) < 2:
        only = times[0] if times else None
        try:
            return {
                name: read(source, name, scene, columns, units, time=only)
                for name, source in programs.items()
            }
        except NoTimesError:
            times = scene.wear.times
            if only is not None or len(times) != len(programs) or not are_steps(programs):
                raise
            LOG.info("%d files without times are at those of the scene", len(times))
    import pandas as pd

    tables = [
        read(source, name, scene, columns, units, time=time)
        for (name, source), time in zip(programs.items(), times, strict=True)
    ]
    return {without_number(next(iter(programs))): pd.concat(tables, ignore_index=True)}


def _scene_of_tables(scene: Scene, tables: "Iterable[pd.DataFrame]") -> Scene:
    """Return a scene at the times and radii of tables, with the quantities that they have."""
    import pandas as pd

    rows = pd.concat(tables)
    radii = scene.problem.radii * scene.problem.units.length
    quantities = scene.output.quantities
    if "all" not in quantities:
        given = rows.columns.drop(["time", "radius"], errors="ignore")
        quantities = [*dict.fromkeys([*quantities, *given])]
    return scene.changed(
        wear__times=np.unique(rows["time"]).tolist(),
        output__radii=np.union1d(radii, rows.get("radius", pd.Series()).dropna()).tolist(),
        output__quantities=quantities,
        output__field_times=None,
    )


def _with_prescribed_force(problem: Problem, solution: Solution) -> Solution:
    """Return a solution that contains the force if it is prescribed, with an error of 0."""
    if problem.response == "normal_force":
        return solution
    force = {"normal_force": problem.loading.at(problem.times).force}
    zero_error = {"normal_force": np.zeros(len(problem.times))}
    return replace(solution, results=force | solution.results, errors=zero_error | solution.errors)
