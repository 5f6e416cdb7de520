"""Press a punch on any compliance: the flat start and the steady state. Non-dimensional, force 1."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import SolverError
from ringwear.meshes.radial import Array
from ringwear.studies.wear.modes import BandedCholesky


@dataclass(frozen=True, eq=False)
class FlatStart:
    """The flat punch (Eqs. 10 and 11 solved by the method at hand): pressure coefficients and indentation."""

    pressure: Array
    indentation: float


@lru_cache(maxsize=8)  # punches that differ in wear alone begin alike
def flat_start(compliance: Compliance) -> FlatStart:
    """Contact of the unworn punch: ``A p = d b``, ``b . p = 1``, with the pressure continuous across ring edges."""
    space = compliance.space
    continuous = space.joined()
    weights = continuous.T @ space.weights
    try:
        solution = cho_solve(cho_factor(continuous.T @ compliance.matrix @ continuous), weights)
    except np.linalg.LinAlgError as error:
        raise SolverError(f"the compliance is not positive definite: {error}; ask for less extreme sizes") from error
    softness = weights @ solution
    return FlatStart(continuous @ solution / softness, float(1 / softness))


@dataclass(frozen=True, eq=False)
class SteadyState:
    """The state that wear tends to (Eqs. 23 to 27): one wear rate everywhere, and the displacement that it makes.

    Parameters
    ----------
    pressure, displacement : coefficients on the pressure space
    moments : (size,) the displacement against each pressure
    wear_rate : the common ``k p``
    """

    pressure: Array
    displacement: Array
    moments: Array
    wear_rate: float


def steady_state(
    compliance: Compliance, wear_coefficients: Array, mass: BandedCholesky, softness: Array | None = None
) -> SteadyState:  # fmt: skip
    """No march: the forces of the rings add up to one; the displacement is projected by the `mass`, of weight `k`.

    `softness` is the compliance times the pressures of the wear rate 1, where it is known.
    """
    space = compliance.space
    pressure = space.ring_indicator() @ (1 / wear_coefficients)
    wear_rate = 1 / (space.weights @ pressure)
    pressure *= wear_rate
    moments = compliance.factor.T @ (compliance.factor @ pressure) if softness is None else wear_rate * softness
    displacement = space.joined() @ mass.solve(space.joined(wear_coefficients).T @ moments)
    return SteadyState(pressure, displacement, moments, float(wear_rate))
