"""Compare the compliances of two methods as operators on one pressure space.

Such a comparison is valid for every pressure of the space instead of one scene. The generalised
eigenvalues of two compliances are the ratios of the elastic energies that they assign to the same
pressures. Three numbers summarise the comparison of a pair: the greatest difference over ring-wise
constant pressures (all steady states, for any wear coefficients), over the pressures of the scene's
history, and over the whole space. The last one is always large, because no method resolves the
shortest waves.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, eigh, solve_triangular

from ....meshes.compliance import Compliance
from ....meshes.errors import SolverError
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array
from ..problem.problem import Problem
from ..wear.full_contact import RunningIn

# name of this comparison in the list of what is left out
OPERATORS = "methods as operators"


@dataclass(frozen=True, eq=False)
class OperatorDifference:
    """Relative differences of the energies by two compliances on one pressure space.

    It is the space of the first method, or a subspace of `MOST_PRESSURES` functions at most.

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


# least ratio of energies (first compliance over second) at which multipliers count as stable
STABLE = 0.01
# largest size of a pressure space for this comparison: the eigenvalues of a larger one would take
# longer than the run itself, so that a subspace is compared instead
MOST_PRESSURES = 1500


def affordable_subspace(space: PressureSpace) -> PressureSpace | None:
    """Return a pressure space, or a coarser subspace of it with at most `MOST_PRESSURES` functions.

    It is None if there are so many rings that no subspace is small enough.
    """
    while space.size > MOST_PRESSURES:
        coarser = space.coarser()
        if coarser.size >= space.size:
            return None
        space = coarser
    return space


def check_multipliers(name: str, first: Compliance, second: Compliance) -> None:
    """Refuse unstable multipliers: some pressure has almost no energy by the first compliance.

    An unstable pair of elements has such pressures (checkerboards). The multipliers are stable if
    the first matrix minus `STABLE` times the second one is positive definite.

    Raises
    ------
    SolverError
        if the energy of some pressure by the first compliance is less than `STABLE` times its
        energy by the second
    """
    try:
        cholesky(first.matrix - STABLE * second.matrix, check_finite=False)
    except np.linalg.LinAlgError:
        raise SolverError(
            f"the multipliers of {name} are unstable on this mesh: the energy of some pressures is "
            f"less than {STABLE:g} of the correct one; choose another degree"
        ) from None


def difference(
    problem: Problem, methods: tuple[str, str], first: RunningIn, second: RunningIn
) -> OperatorDifference:
    """Compare two compliances on the same pressure space, each with the running-in on it."""
    pair, times = (first.compliance, second.compliance), problem.times[problem.compared_rows]
    times = times[problem.loading.at(times).force > 0]
    ratios = eigh(pair[0].matrix, pair[1].matrix, eigvals_only=True)
    # use the pressures of the history instead of the span of the modes, which also contains short
    # waves that hardly occur in the history and that no method resolves
    history = np.zeros(len(times) + 1)
    for wear in (first, second):
        pressures = np.concatenate([wear.modal(times).pressure, wear.steady.pressure[None]])
        history += _energy_differences(*pair, pressures)
    # u = p L / pi under a long wave of length L on a half-space, which defines L for any mode
    values, modes = eigh(pair[1].matrix, pair[0].space.mass().toarray())
    return OperatorDifference(
        methods=methods,
        rings=_over_rings(*pair),
        history=float(history.max()),
        space=float(np.abs(ratios - 1).max()),
        stability=float(ratios.min()),
        wavelengths=np.pi * np.abs(values[::-1]) * problem.units.length,
        differences=_energy_differences(*pair, modes.T)[::-1],
        shortest_resolved=_shortest_resolved_wave(pair[0].space) * problem.units.length,
    )


def _shortest_resolved_wave(space: PressureSpace) -> float:
    """Return the shortest wave that all elements of a pressure space resolve, in punch radii.

    A polynomial needs pi degrees per wave; therefore an element of width h and degree p resolves
    waves down to the length ``pi h / p`` (Gottlieb and Orszag, Numerical Analysis of Spectral
    Methods, 1977, section 3).
    """
    return float(np.pi * (space.widths / space.degrees).max())


def _energy_differences(first: Compliance, second: Compliance, pressures: Array) -> Array:
    """Return (m,) relative differences of the energies of pressures (m, n)."""
    energy, reference = (
        np.sum((pressures @ compliance.factor.T) ** 2, axis=1) for compliance in (first, second)
    )
    # at a fixed indentation the pressure decays to zero: the difference is then 0
    ratios = np.divide(energy, reference, out=np.ones(len(pressures)), where=reference > 0)
    return np.abs(ratios - 1)


def _over_rings(first: Compliance, second: Compliance) -> float:
    """Return the greatest relative difference over all ring-wise constant pressures."""
    pressures = first.space.ring_indicator()
    # use a basis that is orthonormal in the second energy, because roundoff would spoil the ratios
    # of nearly dependent pressures
    triangle = np.linalg.qr(second.factor @ pressures, mode="r")
    image = solve_triangular(triangle, (first.factor @ pressures).T, trans="T").T
    return float(np.abs(np.linalg.svd(image, compute_uv=False) ** 2 - 1).max())


def least_ratio_of_energies(first: Array, second: Array) -> float:
    """Return the least ratio of the energies by two compliances, given their factors (m, n).

    The ratio is the first energy over the second. It is computed from singular values, because an
    eigensolver for the energies themselves cannot resolve ratios below 1e-15.
    """
    scale = np.linalg.norm(second, axis=0)
    triangle = np.linalg.qr(second / scale, mode="r")
    ratios = solve_triangular(triangle, (first / scale).T, trans="T").T
    if first.shape[0] < first.shape[1]:
        return 0.0
    return float(np.linalg.svd(ratios, compute_uv=False)[-1] ** 2)
