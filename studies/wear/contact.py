"""Press a punch on any compliance: the flat start and the steady state. Non-dimensional, force 1."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ringwear.mdr.direct import steady_pressures
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import SolverError
from ringwear.meshes.radial import Array
from ringwear.studies.wear.modes import BandedCholesky


@dataclass(frozen=True, eq=False)
class FlatStart:
    """The flat punch (Eqs. 10 and 11 solved by the method at hand): pressure coefficients and indentation."""

    pressure: Array
    indentation: float


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
    """The state that wear tends to (Eqs. 23 to 27): known pressures, and the displacement they make.

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


def steady_state(compliance: Compliance, wear_coefficients: Array) -> SteadyState:
    """No march and no solve: the pressures are closed form, their displacement is projected on the space."""
    space = compliance.space
    ring_pressures = steady_pressures(space.ring_edges, wear_coefficients)
    pressure = space.ring_indicator() @ ring_pressures
    moments = compliance.factor.T @ (compliance.factor @ pressure)
    worn, continuous = space.joined(wear_coefficients), space.joined()
    mass = BandedCholesky(worn.T @ space.mass(wear_coefficients) @ worn)
    displacement = continuous @ mass.solve(worn.T @ moments)
    return SteadyState(pressure, displacement, moments, float(wear_coefficients[0] * ring_pressures[0]))
