"""Operators: compare the compliances of two methods for every pressure instead of one scene.

The generalised eigenvalues of two compliances on one pressure space are the ratios of the elastic
energies that they assign to the same pressures. Three numbers summarise the comparison of a pair:
the greatest difference over ring-wise constant pressures (all steady states, for any wear
coefficients), over the pressures of the scene's history, and over the whole space. The last one is
always large, because no method resolves the shortest waves.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from time import process_time

import numpy as np
import pandas as pd
from scipy.linalg import eigh

from ..meshes import Array, PressureSpace, SceneError
from .crosscheck import (
    AnySpaceMethod,
    Method,
    Problem,
    RunningIn,
    Scene,
    Source,
    naming_arguments,
    run,
)
from .study.answer import answer
from .study.draw import draw, titled
from .study.errors import STABLE, energy_differences, energy_ratios
from .study.own import Methods, read_methods
from .study.record import SOLVED, Record
from .study.study import Study, remarks
from .study.way import ALL, Case

METHODS = ("fem", "mdr", "bem")
"""Methods that compute a compliance, by their names in the option `methods`."""
QUICK_RTOL = 1e-2
"""Least tolerance of the quick study."""
LEAST_RATIO = "least ratio of energies"
"""Name of the quantity whose entry in the column `error` is the value itself."""
TITLE = "the methods compared for every pressure, one mark per mode"
WAVELENGTH = "wavelength of the pressure over the punch radius a"


@dataclass(frozen=True, eq=False)
class OperatorDifference:
    """Relative differences of the energies by two compliances on one pressure space.

    It is the space of the first method.

    Parameters
    ----------
    methods : names of the two methods
    rings : greatest difference over all ring-wise constant pressures
    history : greatest difference over the pressures of the scene's history and steady state. At
        each time it is the sum of the differences for the pressures of both methods, which bounds
        the relative difference of their indentations
    space : greatest difference over all pressures of the space
    stability : least ratio of the energies: the square of the inf-sup constant of the multipliers
    wavelengths, differences : of each pressure mode, the slowest first; wavelengths in the scene's
        unit of length
    shortest_resolved : shortest wave that all elements of the pressure space resolve, in the same
        unit
    """

    methods: tuple[str, str]
    rings: float
    history: float
    space: float
    stability: float
    wavelengths: Array
    differences: Array
    shortest_resolved: float


@naming_arguments
def compare_operators(
    scene: Source,
    methods: Sequence[str | Method] | str | None = None,
    rtol: float | None = None,
) -> tuple[OperatorDifference, ...]:
    """Run a scene of a flat punch, and compare the compliances of every two methods.

    A method that has a fixed pressure space (finite elements, on their contact facets) determines
    the space; the other methods compute their compliance on it. Two methods with fixed spaces are
    not compared.

    Parameters
    ----------
    scene, methods, rtol : as for `run`

    Raises
    ------
    SceneError
        if the punch is not flat, or if no two methods can be compared

    Examples
    --------
    >>> from ringwear import compare_operators
    >>> (pair,) = compare_operators("five_rings", methods=["mdr", "bem"], rtol=1e-3)
    >>> pair.methods
    ('mdr', 'bem')
    >>> pair.rings < 1e-9
    True
    """
    if not Scene.of(scene).problem.full_contact:
        raise SceneError(
            "methods are compared as operators only for flat punches: leave out punch.recess and "
            "punch.profile"
        )
    result = run(scene, methods, rtol)
    wears = {
        name: solution.wear
        for name, solution in result.solutions.items()
        if solution.wear is not None
    }
    any_space = {name for name in wears if isinstance(result.methods[name], AnySpaceMethod)}
    pairs = list[OperatorDifference]()
    for a, b in combinations(sorted(wears, key=any_space.__contains__), 2):
        other = result.methods[b]
        if isinstance(other, AnySpaceMethod):
            problem, running_in = result.scene.problem, wears[a]
            reference = other.compliance(running_in.compliance.space, problem.ground)
            second = replace(running_in, compliance=reference)
            pairs.append(difference(problem, (a, b), running_in, second))
    if not pairs:
        raise SceneError(
            "there are no two methods to compare as operators: give methods = ['fem', 'mdr'], or "
            "another method that computes a compliance together with mdr or bem"
        )
    return tuple(pairs)


def difference(
    problem: Problem, methods: tuple[str, str], first: RunningIn, second: RunningIn
) -> OperatorDifference:
    """Compare two compliances on the same pressure space, each with the running-in on it."""
    ours, exact, space = first.compliance, second.compliance, first.compliance.space
    times = problem.times[problem.compared_rows]
    times = times[problem.loading.at(times).force > 0]
    ratios = energy_ratios(ours.factor, exact.factor)
    constants = space.ring_indicator()
    of_rings = energy_ratios(ours.factor @ constants, exact.factor @ constants)
    # use the pressures of the history instead of the span of the modes, which also contains short
    # waves that hardly occur in the history and that no method resolves
    history = np.zeros(len(times) + 1)
    for wear in (first, second):
        pressures = np.concatenate([wear.modal(times).pressure, wear.steady.pressure[None]])
        history += np.abs(energy_differences(exact, ours, pressures))
    # u = p L / pi under a long wave of length L on a half-space, which defines L for any mode
    values, modes = eigh(exact.matrix, space.mass().toarray())
    return OperatorDifference(
        methods=methods,
        rings=float(np.abs(of_rings - 1).max()),
        history=float(history.max()),
        space=float(np.abs(ratios - 1).max()),
        stability=float(ratios.min()),
        wavelengths=np.pi * np.abs(values[::-1]) * problem.units.length,
        differences=np.abs(energy_differences(exact, ours, modes.T))[::-1],
        shortest_resolved=_shortest_resolved_wave(space) * problem.units.length,
    )


def _shortest_resolved_wave(space: PressureSpace) -> float:
    """Return the shortest wave that all elements of a pressure space resolve, in punch radii.

    A polynomial needs pi degrees per wave; therefore an element of width h and degree p resolves
    waves down to the length ``pi h / p`` (Gottlieb and Orszag, Numerical Analysis of Spectral
    Methods, 1977, section 3).
    """
    return float(np.pi * (space.widths / space.degrees).max())


def operators(
    scene: Source = "five_rings",
    *,
    methods: Methods = None,
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Compare two methods for every pressure at once, by the energies that they assign to it.

    Parameters
    ----------
    scene : a scene of a flat punch
    methods : names of methods that compute a compliance, and your own methods; by default `fem` and
        `mdr`
    quick : whether to compare coarse discretisations
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene does not fit the study, or if no two methods can be compared
    """
    scene, record = Scene.of(scene), record or Record()
    names, own = read_methods(methods or METHODS[:2], METHODS, "operators")
    rtol = max(scene.accuracy.rtol, QUICK_RTOL) if quick else scene.accuracy.rtol
    start = process_time()
    pairs = compare_operators(scene, [*names, *own], rtol)
    level = {
        "case": Case.of(scene).name,
        "level": f"rtol {rtol:g}",
        "seconds": process_time() - start,
        "when": ALL,
        "outcome": SOLVED,
    }
    modes, drawn, radius = list[pd.DataFrame](), list[pd.DataFrame](), scene.punch.radius
    for pair in pairs:
        way = {"way": " over ".join(pair.methods), "method": pair.methods[0]}
        row = level | way | {"unknowns": len(pair.differences)}
        numbers = {
            "ring-wise constant pressures": pair.rings,
            "pressures of the history": pair.history,
            "all pressures": pair.space,
            LEAST_RATIO: pair.stability,
        }
        record.add([row | {"quantity": name, "error": value} for name, value in numbers.items()])
        columns = {"wavelength": pair.wavelengths, "difference": pair.differences}
        modes.append(pd.DataFrame({"way": way["way"]} | columns))
        panel = row | {"quantity": "difference of energies", "refined": WAVELENGTH}
        panel |= {
            "unresolved": pair.shortest_resolved / radius,
            "reference": 0.0,
            "tolerance": np.nan,
        }
        sizes = pair.wavelengths / radius
        drawn.append(pd.DataFrame(panel | {"size": sizes, "error": pair.differences}))
        steady = {"way": f"{way['way']}, all steady states", "error": pair.rings}
        drawn.append(pd.DataFrame(panel | steady | {"size": [sizes.min(), sizes.max()]}))
    return Study(
        "operators",
        scene,
        record.table,
        conclusions=(*map(_conclude, pairs), *remarks(record, quick)),
        figures={"operator_difference": draw(pd.concat(drawn), title=titled(scene.title, TITLE))},
        tables={"modes": pd.concat(modes)},
        measured=record.table,
        answer=answer(record.table),
    )


def _conclude(pair: OperatorDifference) -> str:
    """Return a sentence on the differences of two methods, and on the stability of multipliers."""
    stable = "stable" if pair.stability >= STABLE else "UNSTABLE: choose another degree"
    return (
        f"As operators, {' and '.join(pair.methods)} differ by {pair.rings:.1e} over all steady "
        f"states and {pair.history:.1e} along this history; the least ratio of their energies is "
        f"{pair.stability:.2g}: the multipliers are {stable}."
    )
