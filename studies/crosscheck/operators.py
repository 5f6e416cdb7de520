"""Compare two methods as operators.

On one pressure space, for every pressure at once instead of for one scene.

The generalised eigenvalues of two compliances are the ratios of the energies that they give to the
same pressures. Three numbers certify a pair: over ring-wise constant pressures (every steady state,
whatever the wear coefficients), over the pressures that the scene's history passes through, and
over the whole space, where the shortest pressures are never resolved. Beside them stands a
residual: the pressures of one method, put into the other.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, solve_triangular

from ...meshes.compliance import Compliance
from ...meshes.errors import SolverError
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..wear.full_contact import RunningIn

# below this share of the energy of a pressure, the multipliers no longer see the displacement: a
# checkerboard
LEAST_STABLE = 0.01


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
    space : over all pressures of the space; `worst_radius` is where the worst of them is greatest
    stability : least ratio of the energies: the square of the inf-sup constant of the multipliers
    residual : displacements that the second method gives to the pressures of the first, against the
        worn profile, in the energy norm: the greatest over the history
    wavelengths, differences : by pressure mode, the slowest first
    """

    methods: tuple[str, str]
    rings: float
    history: float
    space: float
    worst_radius: float
    stability: float
    residual: float
    wavelengths: Array
    differences: Array

    def check_multipliers(self) -> None:
        """Refuse multipliers of the first method that no longer see the displacement.

        Raises
        ------
        SolverError
            if pressures exist that it gives next to no energy
        """
        if self.stability < LEAST_STABLE:
            raise SolverError(
                f"the multipliers of {self.methods[0]} are unstable on this mesh: some pressures "
                f"have {self.stability:.1e} "
                "of their energy; choose another degree"
            )


def difference(
    problem: Problem, methods: tuple[str, str], first: RunningIn, second: RunningIn
) -> OperatorDifference:
    """Compare two compliances, each with the running-in on it, on the same pressure space."""
    one, other = first.compliance, second.compliance
    ratios, shapes = _pencil(one.matrix, other.matrix)
    worst = int(np.abs(ratios - 1).argmax())
    fine = np.linspace(0, 1, 2001)
    pressure = one.space.matrix(fine) @ shapes[:, worst]
    wavelengths, by_mode = _spectrum(one, other)
    return OperatorDifference(
        methods=methods,
        rings=_greatest(one, other, one.space.ring_indicator()),
        history=_along_history(problem.times[problem.checked], first, second),
        space=float(np.abs(ratios[worst] - 1)),
        worst_radius=float(fine[np.abs(pressure).argmax()]) * problem.units.length,
        stability=float(ratios.min()),
        residual=_residual(problem.times[problem.checked], first, other),
        wavelengths=wavelengths * problem.units.length,
        differences=by_mode,
    )


def _pencil(first: Array, second: Array) -> tuple[Array, Array]:
    try:
        return eigh(first, second)
    except np.linalg.LinAlgError as error:
        raise SolverError(
            f"two compliances cannot be compared: one is not positive definite ({error})"
        ) from error


def _greatest(first: Compliance, second: Compliance, pressures: Array) -> float:
    """max |ratio - 1| over the span of some pressures (size, m)."""
    # an orthonormal basis in the second energy: ratios of nearly dependent pressures would be lost
    # to roundoff
    basis, triangle = np.linalg.qr(second.factor @ pressures)
    image = solve_triangular(triangle, (first.factor @ pressures).T, trans="T").T
    return (
        float(np.abs(np.linalg.svd(image, compute_uv=False) ** 2 - 1).max()) if basis.size else 0.0
    )


def _along_history(times: Array, first: RunningIn, second: RunningIn) -> float:
    """Energies of the same pressures by both methods, along the histories of both.

    The span of the modes would not do: it holds short waves that the history hardly touches, and no
    method resolves.
    """
    total = np.zeros(len(times) + 1)
    for wear in (first, second):
        pressures = np.concatenate([wear.modal(times).pressure, wear.steady.pressure[None]])
        own = np.sum((pressures @ first.compliance.factor.T) ** 2, axis=1)
        total += np.abs(own / np.sum((pressures @ second.compliance.factor.T) ** 2, axis=1) - 1)
    return float(total.max())


def _spectrum(first: Compliance, second: Compliance) -> tuple[Array, Array]:
    """Wavelengths of the modes of the second compliance, and relative differences of their
    energies.

    On a long wave of length L a half-space gives ``u = p L / pi``, which defines the length of any
    mode.
    """
    values, shapes = eigh(second.matrix, second.space.mass().toarray())
    own = np.sum((first.factor @ shapes) ** 2, axis=0)
    other = np.sum((second.factor @ shapes) ** 2, axis=0)
    return np.pi * np.abs(values[::-1]), np.abs(own / other - 1)[::-1]


def _residual(times: Array, first: RunningIn, second: Compliance) -> float:
    """Energy norm of ``u_second[p_first] + f - d`` over that of the pressure.

    The greatest over the times.
    """
    later = times[times > 0]
    if not len(later):
        return 0.0
    history = first.modal(later)
    space = second.space
    gap = history.indentation[:, None] * space.weights - history.profile @ space.mass()
    # tested with the pressures that the history lives in
    test = space.joined(first.wear_coefficients)
    triangle = np.linalg.qr(second.factor @ test, mode="r")
    residual = (history.pressure @ second.matrix - gap) @ test
    size = np.linalg.norm(solve_triangular(triangle, residual.T, trans="T"), axis=0)
    return float((size / np.linalg.norm(history.pressure @ second.factor.T, axis=1)).max())
