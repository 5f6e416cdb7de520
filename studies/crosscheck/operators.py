"""Compare two methods as operators.

On one pressure space, for every pressure at once instead of for one scene.

The generalised eigenvalues of two compliances are the ratios of the energies that they give to the
same pressures. Three numbers certify a pair: over ring-wise constant pressures (every steady state,
whatever the wear coefficients), over the pressures that the scene's history passes through, and
over the whole space, where the shortest pressures are never resolved.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, eigh, solve_triangular

from ...meshes.compliance import Compliance
from ...meshes.errors import SolverError
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..wear.full_contact import RunningIn


@dataclass(frozen=True, eq=False)
class OperatorDifference:
    """How far one compliance is from another, relative, on the pressure space of the first.

    Parameters
    ----------
    methods : the two
    rings : over all ring-wise constant pressures
    history : over the pressures of this scene's history: of the two methods' at each time, and of
        the steady state, the sum of both, which bounds the relative difference of their
        indentations
    space : over all pressures of the space
    stability : least ratio of the energies: the square of the inf-sup constant of the multipliers
    wavelengths, differences : by pressure mode, the slowest first
    shortest_resolved : shortest wave that the elements of the pressure space resolve everywhere, in
        the unit of the wavelengths
    """

    methods: tuple[str, str]
    rings: float
    history: float
    space: float
    stability: float
    wavelengths: Array
    differences: Array
    shortest_resolved: float


# part of the energy of every pressure that stable multipliers give it at the least
STABLE = 0.01
# pressures beyond which eigenvalues of all of them would take longer than the run itself
MOST_PRESSURES = 1500


def check_multipliers(name: str, first: Compliance, second: Compliance) -> None:
    """Refuse multipliers of the first method that no longer see the displacement.

    A checkerboard has next to no energy. The energies differ by a positive definite matrix if no
    pressure has so little of it.

    Raises
    ------
    SolverError
        if the first compliance gives some pressure less than `STABLE` times its energy by the
        second
    """
    try:
        cholesky(first.matrix - STABLE * second.matrix, check_finite=False)
    except np.linalg.LinAlgError:
        raise SolverError(
            f"the multipliers of {name} are unstable on this mesh: some pressures have less than "
            f"{STABLE:g} of their energy; choose another degree"
        ) from None


def difference(
    problem: Problem, methods: tuple[str, str], first: RunningIn, second: RunningIn
) -> OperatorDifference:
    """Compare two compliances, each with the running-in on it, on the same pressure space."""
    pair, times = (first.compliance, second.compliance), problem.times[problem.checked]
    times = times[problem.loading.at(times).force > 0]
    ratios = eigh(pair[0].matrix, pair[1].matrix, eigvals_only=True)
    # the span of the modes would not do: it holds short waves that the history hardly touches, and
    # no method resolves
    history = np.zeros(len(times) + 1)
    for wear in (first, second):
        pressures = np.concatenate([wear.modal(times).pressure, wear.steady.pressure[None]])
        history += _energy_differences(*pair, pressures)
    # on a long wave of length L a half-space gives u = p L / pi: the length of any mode
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

    A polynomial of degree p takes pi degrees for each wave, so that an element of width h resolves
    waves down to ``pi h / p`` (Gottlieb and Orszag, Numerical Analysis of Spectral Methods, 1977,
    section 3). A hole, whose degree is zero, has no pressure.
    """
    carries = space.degrees > 0
    return float(np.pi * (space.widths[carries] / space.degrees[carries]).max())


def _energy_differences(first: Compliance, second: Compliance, pressures: Array) -> Array:
    """Return (m,) relative differences of the energies of pressures (m, n)."""
    energy, reference = (
        np.sum((pressures @ compliance.factor.T) ** 2, axis=1) for compliance in (first, second)
    )
    # at a fixed indentation no pressure is left in the end
    ratios = np.divide(energy, reference, out=np.ones(len(pressures)), where=reference > 0)
    return np.asarray(np.abs(ratios - 1))


def _over_rings(first: Compliance, second: Compliance) -> float:
    """Return the greatest relative difference over all ring-wise constant pressures."""
    pressures = first.space.ring_indicator()
    # an orthonormal basis in the second energy: ratios of nearly dependent pressures would be lost
    # to roundoff
    triangle = np.linalg.qr(second.factor @ pressures, mode="r")
    image = solve_triangular(triangle, (first.factor @ pressures).T, trans="T").T
    return float(np.abs(np.linalg.svd(image, compute_uv=False) ** 2 - 1).max())


def least_ratio_of_energies(first: Array, second: Array) -> float:
    """Return the least ratio of energies, that by the first factor (m, n) over that by the second.

    By singular values: an eigensolver of the energies themselves would lose those below 1e-15.
    """
    scale = np.linalg.norm(second, axis=0)
    triangle = np.linalg.qr(second / scale, mode="r")
    ratios = solve_triangular(triangle, (first / scale).T, trans="T").T
    if first.shape[0] < first.shape[1]:
        return 0.0
    return float(np.linalg.svd(ratios, compute_uv=False)[-1] ** 2)
