"""Run a scene: solve it by every method, estimate errors, and judge whether the methods agree."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations

from threadpoolctl import threadpool_limits

from ....meshes.errors import SceneError
from ..copies import Apart, here
from ..methods.base import Method, Solution
from ..methods.inside.interior import Interior, has_inside, interior
from ..problem.written import shown
from ..progress import Stages
from ..registry import METHODS
from ..scene.calls import naming_arguments
from ..scene.keys import listed
from ..scene.scene import Scene, Source
from ..verdict.accuracy import solved_to_accuracy
from ..verdict.agreement import agreements, unchecked
from .judgement import Judged
from .predictions import accepted_methods
from .result import Result, methods_with_fields
from .table import answers_of, tabulate


@naming_arguments
def run(
    scene: Source,
    methods: Sequence[str | Method] | str | None = None,
    rtol: float | None = None,
    quantities: Sequence[str] | str | None = None,
    memory: float | None = None,
) -> "Result":
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Every method solves the same problem: a rigid punch of concentric rings on an elastic
    half-space that wears by Archard's law ``df/dt = k p v``. Each method estimates its own errors,
    so that two methods can be compared.

    Parameters
    ----------
    scene : Scene, str, Path or dict
        Punch, half-space, load, times and the relative tolerance ``rtol``: a Scene, the name of a
        bundled scene, a file, or nested dictionaries. Its numbers are in any consistent units.
    methods : sequence of str or Method, optional
        Names of methods, or your own Method objects, instead of the scene's methods. Results and
        figures are in this order. If neither gives any, those of 'mdr', 'direct' and 'fem' that can
        solve the scene; ``summary["left_out"]`` names the others, with the reasons.

        ========  ========================  ========================  ==================  =======
        name      gives                     punches                   error falls         seconds
        ========  ========================  ========================  ==================  =======
        mdr       start, history, steady    all                       exponentially       0.13
        bem       start, history, steady    all                       exponentially       0.10
        fem       the same, and the inside  all                       exponentially       0.48
        direct    steady                    k constant on rings       closed form         0.002
        mdr-grid  start, history            flat discs, as `direct`   as step and cell    0.55
        ========  ========================  ========================  ==================  =======

        * 'mdr' (dimensionality reduction): the default choice. Its energy is exact for every
          axisymmetric pressure, so that only the pressures and, for shaped punches, the time steps
          are discretised.
        * 'bem' (boundary elements): the same pressures with the ring kernel of Eq. 19. It uses no
          identity of the MDR; choose it to check 'mdr' at the same cost.
        * 'fem' (finite elements): a meshed half-space with Boussinesq's far field. It shares
          neither a kernel nor a mesh with the others, and is the only method with displacements
          and stresses inside the half-space. Choose it as the independent check, or to test a mesh.
          On triangles its energies converge with order 2k in the element size, for displacements of
          degree k.
        * 'direct' (direct integration, Eqs. 21 to 27): the steady state to roundoff. Choose it if
          no history is needed, especially in sweeps. It refuses a wear coefficient that varies
          along the radius, and a fixed indentation, under which the pressure decays to zero.
        * 'mdr-grid' (the algorithm of the paper): springs on a uniform grid and explicit steps, of
          first order in both; the indentation of five rings with 400 springs has the relative error
          1.8e-3. Choose it to reproduce the paper. It also refuses hollow punches, loads that vary,
          and scenes without times.

        "Exponentially" refers to the number of unknowns, for contact whose edges do not move. While
        edges move, pressures are linear on cells, and time steps are of second order. The seconds
        are those of solving `five_rings` at ``rtol = 1e-4`` on one core, including the error
        estimate, as in `summary.json`.

    rtol : float, optional
        Relative tolerance, instead of the scene's.
    quantities : sequence of str, optional
        Names of quantities, or of groups of them, instead of the scene's.
    memory : float, optional
        Largest memory to use, in GiB; by default that of the machine. A run that is predicted to
        need more is refused.

    Returns
    -------
    Result
        With the following attributes, among others:

        dataset : xarray.Dataset
            Quantities by solver, time, radius, ring and mode, in the scene's units; the relative
            error estimate of each is in ``<quantity>_error``. NaN if a method does not compute it.
        answers : dict
            The numbers of the answer, by method.
        verdict : str
            "agree", "disagree" or "undecided".
        agreement : tuple of Agreement
            The verdict on each quantity and pair of methods.
        anchors : tuple of Anchor
            Comparisons of reported numbers with closed forms and conservation laws.
        operators : tuple of OperatorDifference
            Comparisons of methods for every pressure at once.
        warnings : tuple of str
            What to know before the numbers are used, such as that linear elasticity is not valid.
        summary : dict
            All of these except the fields, and the seconds, sizes and notes of each method.

    Raises
    ------
    SceneError
        If a method cannot solve the scene, or if memory does not suffice; the message names the key
        and the remedy. This is raised before anything is computed.
    MeshError
        If a mesh of the half-space cannot be generated.
    SolverError
        If a linear system has no meaningful solution.

    Notes
    -----
    **Accuracy.** ``rtol`` bounds the relative error of every quantity in the norm of the quantity.
    If a method's error estimates are larger, it solves again with finer sizes, unless the scene
    gives the sizes. `Result.left_out_of_promise` lists the quantities and times for which this
    accuracy is not promised, with the reasons.

    **Verdict.** Two methods *agree* on a quantity if, at every time, both error estimates are at
    most ``rtol`` (twice that while edges of the contact move) and the difference is at most twice
    this bound. They *disagree* if the difference is larger than that and larger than the sum of
    both error estimates. All other cases are *undecided*. The verdict on the run is the worst one
    on the promised quantities. It is "disagree" if an anchor does not hold, and "undecided" if an
    anchor is missing or if one method alone computes a quantity. A larger error estimate never
    turns a verdict into "agree".

    Progress is logged by the logger `ringwear`.

    Examples
    --------
    Five rings under the force 2, with the radius 1 and the plane strain modulus 1, start at
    ``d = F / (2 a E*) = 1``:

    >>> result = run("five_rings", methods=["mdr", "direct"])
    >>> start = result.dataset.indentation.sel(solver="mdr", time=0.0)
    >>> bool(abs(start - 1.0) < 1e-4)
    True

    Both methods give the steady state, in which all rings wear at one rate. Nothing checks the
    history, which 'direct' does not compute:

    >>> rates = result.dataset.steady_wear_rate
    >>> bool(abs(rates.sel(solver="mdr") / rates.sel(solver="direct") - 1) < 1e-4)
    True
    >>> result.verdict
    'undecided'
    """
    entries = listed(() if methods is None else methods)
    if invalid := [entry for entry in entries if not isinstance(entry, str | Method)]:
        raise SceneError(
            f"methods has {shown(invalid[0])}: give names, {', '.join(METHODS)}, or objects of a "
            "Method"
        )
    named = all(isinstance(entry, str) for entry in entries)
    names = [str(entry) for entry in entries] if named and methods is not None else None
    scene = Scene.of(scene, names, rtol, quantities)
    return begun(scene, accepted_methods(scene, entries, memory))()


def begun(
    scene: Scene, methods: Mapping[str, Method], apart: Apart = here, with_inside: bool = False
) -> Callable[[], Result]:
    """Solve a scene; return a function that waits for the finite elements, and judges all results.

    Parameters
    ----------
    scene, methods : the scene, and methods that can solve it, by name
    apart : begins the finite elements, which take about as long as the other methods together
    with_inside : whether the fields inside the half-space are begun, too
    """
    solutions = dict[str, Solution]()
    stages = {name: Stages(name, apart=apart if name == "fem" else here) for name in methods}

    def solve(name: str) -> tuple[Solution, dict[str, float]]:
        # one thread: the matrices are small, and threads of two linear algebra libraries would
        # mostly wait for each other
        with threadpool_limits(1):
            (solutions[name],) = solved_to_accuracy(methods[name], [scene.problem], stages[name])
        return solutions[name], stages[name].seconds

    def inside() -> Interior | None:
        wanted = with_inside and has_inside(scene, solutions["fem"])
        return interior(scene, solutions["fem"]) if wanted else None

    begun_works = apart(partial(solve, "fem"), inside) if "fem" in methods else ()
    for name in methods:
        if name != "fem":
            solve(name)

    def complete() -> Result:
        begun_inside = None
        if begun_works:
            of_fem, begun_inside = begun_works
            solutions["fem"], stages["fem"].seconds = of_fem()
        in_order = {name: solutions[name] for name in methods}
        return replace(judged(scene, methods, in_order, stages), begun_inside=begun_inside)

    return complete


def judged(
    scene: Scene,
    methods: Mapping[str, Method],
    solutions: Mapping[str, Solution],
    stages: Mapping[str, Stages],
) -> Result:
    """Return the result that consists of solutions of a scene, which are compared with each other.

    Parameters
    ----------
    scene : the scene that was solved
    methods : the methods by name
    solutions : the solution of each method
    stages : the seconds of each stage, by method
    """
    problem, units = scene.problem, scene.unit_names
    agreement = tuple(
        row
        for a, b in combinations(solutions, 2)
        for row in agreements(problem, (a, b), (solutions[a], solutions[b]), units)
    ) + tuple(unchecked(problem, solutions))
    table = tabulate(scene, solutions)
    answers = answers_of(table)
    notes = [note for solution in solutions.values() for note in solution.notes]
    return Result(
        scene,
        methods,
        table,
        answers,
        agreement,
        Judged(scene, table, answers, solutions, agreement),
        tuple(dict.fromkeys(notes)),
        solutions,
        stages,
        compared_in_fields=methods_with_fields(table),
    )


def with_others(
    result: Result, programs: Mapping[str, Method], others: Mapping[str, Solution]
) -> Result:
    """Return a result with results of other programs beside it, for figures and for files.

    The judgement stays that of our results: others are judged by their errors (`studies/check/`).

    Parameters
    ----------
    programs, others : the other programs, and their results, by name
    """
    solutions = {**result.solutions, **others}
    table = tabulate(result.scene, solutions)
    return replace(
        result,
        methods={**result.methods, **programs},
        table=table,
        answers=answers_of(table),
        solutions=solutions,
        stages={**result.stages, **{name: Stages(name) for name in others}},
        of_others=tuple(others),
    )
