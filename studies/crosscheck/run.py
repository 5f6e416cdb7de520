"""Run a scene: every method, its own error estimate, and the verdict on how far they agree."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

from threadpoolctl import threadpool_limits

from ...meshes.errors import SceneError
from ..methods.base import Method, Solution
from ..methods.pipeline import AnySpaceMethod
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..progress import Stages
from .accuracy import solved_to_accuracy
from .agreement import agreements
from .dataset import Result
from .operators import MOST_PRESSURES, OperatorDifference, check_multipliers, difference
from .scope import methods_of, refusals


def run(scene: Scene, methods: Sequence[str | Method] | None = None) -> Result:
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Every method solves the same problem: a rigid punch of concentric rings on an elastic
    half-space, which wears by Archard's law ``df/dt = k p v``. Each estimates its own errors, so
    that two methods can be compared.

    Parameters
    ----------
    scene : Scene
        What is computed: punch, half-space, load, times, and the relative accuracy ``rtol``. Its
        numbers are in any consistent units.
    methods : sequence of str or Method, optional
        Methods in place of the scene's, by their names, or as objects of one's own. Their order is
        that of results and figures.

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
          axisymmetric pressure, so that only the pressures and, for shaped punches, the steps are
          discretised.
        * 'bem' (boundary elements): the same pressures by the ring kernel of Eq. 19. It uses no
          identity of the MDR: choose it to check 'mdr' at the same cost.
        * 'fem' (finite elements): a meshed half-space with Boussinesq's far field. It shares
          neither a kernel nor a mesh with the others, and alone gives displacements and stresses
          inside. Choose it as the independent check, or to test a mesh. On triangles its energies
          are of order 2k in the element size, for displacements of degree k.
        * 'direct' (direct integration, Eqs. 21 to 27): the steady state to roundoff. Choose it
          where no history is wanted, in sweeps above all. It refuses a wear coefficient that varies
          along the radius, and a fixed indentation, under which nothing presses in the end.
        * 'mdr-grid' (the algorithm of the paper): springs on a uniform grid and explicit steps, of
          first order in both; five rings by 400 springs err by 1.8e-3 in the indentation. Choose it
          to reproduce the paper. It also refuses hollow punches, loads that vary, and scenes
          without times.

        "Exponentially" is with the number of unknowns, for contact whose edges do not move. While
        edges move, pressures are linear on cells, and steps in time are of second order. Seconds
        are those of solving `five_rings` at ``rtol = 1e-4`` on one core, with the error estimate,
        as `summary.json` lists them.

    Returns
    -------
    Result
        With the following attributes, among others:

        dataset : xarray.Dataset
            Quantities by solver, time, radius, ring and mode, in the scene's units; the relative
            error estimate of each is in ``<quantity>_error``. NaN where a method does not give it.
        answers : dict
            The numbers of the answer, by method.
        verdict : str
            "agree", "disagree" or "undecided".
        agreement : tuple of Agreement
            A row for each quantity and pair of methods.
        anchors : tuple of Anchor
            Comparisons of reported numbers with closed forms and conservation laws.
        operators : tuple of OperatorDifference
            Comparisons of methods for every pressure at once.
        summary : dict
            All of that but the fields, and the seconds, sizes and notes of each method.

    Raises
    ------
    SceneError
        If a method cannot solve the scene; the message names the key and the remedy. Nothing is
        computed then.
    MeshError
        If a mesh of the half-space cannot be made.
    SolverError
        If a system has no meaningful solution.

    Notes
    -----
    **Accuracy.** ``rtol`` bounds the relative error of every quantity, each in a norm of its own.
    A method whose own estimates fall short of it solves again with finer sizes, unless the scene
    gives the sizes. `Result.left_out_of_promise` lists what cannot be promised, and why.

    **Verdict.** Two methods *agree* on a quantity if, at every time, each states an error of at
    most ``rtol`` (twice that while edges of the contact move) and they differ by at most twice
    what each may state. They *disagree* if they differ by more than that and by more than the sum
    of their error estimates. All else is *undecided*. The verdict on the run is the least of all
    that is promised. It is "disagree" if an anchor does not hold, and "undecided" if an anchor is
    missing or if there is one method only. A larger error estimate never turns a verdict into
    "agree".

    Progress goes to the logger `ringwear`.

    Examples
    --------
    Five rings under the force 2, with the radius 1 and the plane strain modulus 1, start at
    ``d = F / (2 a E*) = 1``:

    >>> result = run(Scene.load("five_rings"), methods=["mdr", "direct"])
    >>> start = result.dataset.indentation.sel(solver="mdr", time=0.0)
    >>> bool(abs(start - 1.0) < 1e-4)
    True

    Both methods give the steady state, in which all rings wear at one rate:

    >>> rates = result.dataset.steady_wear_rate
    >>> bool(abs(rates.sel(solver="mdr") / rates.sel(solver="direct") - 1) < 1e-4)
    True
    >>> result.verdict
    'agree'
    """
    by_name, problem = methods_of(methods or scene.methods), scene.problem
    if refused := refusals(scene, by_name):
        raise SceneError(refused[0])
    stages = {name: Stages(name) for name in by_name}
    # the dense matrices are small: threads of two linear algebra libraries would spend their time
    # waiting on each other
    with threadpool_limits(1):
        solutions = {
            name: solved_to_accuracy(entry, [problem], stages[name])[0]
            for name, entry in by_name.items()
        }
        operators = tuple(compare_operators(problem, by_name, solutions))
    agreement = tuple(
        row
        for a, b in combinations(solutions, 2)
        for row in agreements(problem, (a, b), (solutions[a], solutions[b]))
    )
    return Result(scene, by_name, solutions, stages, agreement, operators)


def compare_operators(
    problem: Problem, methods: Mapping[str, Method], solutions: Mapping[str, Solution]
) -> Iterator[OperatorDifference]:
    """Compare methods as operators: each on the space of another, where it can be had there.

    A method with a space of its own (the finite elements, on their contact facets) gives the space;
    the others follow.
    """
    wears = {
        name: solution.wear for name, solution in solutions.items() if solution.wear is not None
    }
    anywhere = {name for name in wears if isinstance(methods[name], AnySpaceMethod)}
    for a, b in combinations(sorted(wears, key=anywhere.__contains__), 2):
        other = methods[b]
        if problem.full_contact and isinstance(other, AnySpaceMethod):
            with Stages("check")(f"{a} against {b}"):
                first, space = wears[a], wears[a].compliance.space
                second = replace(first, compliance=other.compliance(space))
                if a not in anywhere:
                    check_multipliers(a, first.compliance, second.compliance)
                if space.size <= MOST_PRESSURES:
                    yield difference(problem, (a, b), first, second)
