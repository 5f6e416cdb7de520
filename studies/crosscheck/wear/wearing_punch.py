"""Describe a punch that wears: its compliance, wear coefficients, unworn face and load."""

from dataclasses import dataclass, field
from functools import cached_property

from ....meshes.compliance import Compliance
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array
from ..problem.loading import Loading
from .full_contact import RunningIn
from .unilateral import Load


@dataclass(frozen=True, eq=False)
class WearingPunch:
    """A punch that wears, and whose contact may open, close and spread. Non-dimensional.

    `evolve` returns its states over time. In the example, the punch is a paraboloid, and the worn
    volume is k F t.

    >>> import numpy as np
    >>> from ringwear import ContactCells, energy, evolve
    >>> space = ContactCells((0.0, 1.0), largest=0.05, edge_size=0.01).space()
    >>> heights = space.mass() @ space.at_vertices(np.ones(1)) ** 2  # of a flat face
    >>> punch = WearingPunch(energy.compliance(space), np.ones(1), heights, Load(0.1))
    >>> evolve(punch, 2.0, 1e-3).at(np.array([0.0, 1.0, 2.0])).profile @ space.weights
    array([0. , 0.1, 0.2])

    Parameters
    ----------
    compliance : Compliance
        Compliance on a space of continuous piecewise linear pressures.
    wear_coefficients : (N,) or (2, N) array
        Wear coefficient of each ring of that space; or those at the inner and outer edge of each
        ring, linear between.
    moments : (size,) array
        Moments of the unworn face.
    load : Load
        Greatest force, or indentation.
    loading : Loading, optional
        Force over the greatest force, and sliding speed, over time; constant if not given.
    """

    compliance: Compliance
    wear_coefficients: Array
    moments: Array
    load: Load
    loading: Loading = field(default_factory=Loading)

    @property
    def space(self) -> PressureSpace:
        """The space of the pressures."""
        return self.compliance.space

    @cached_property
    def running_in(self) -> RunningIn:
        """The relaxation modes and the steady state in full contact."""
        return RunningIn(
            self.compliance,
            self.wear_coefficients,
            continuous=False,
            indentation=self.load.indentation,
        )

    @property
    def slowest_time(self) -> float:
        """The slowest relaxation time in full contact."""
        return float(self.running_in.slowest_times[0])

    def even_wear(self, distances: Array) -> Array:
        """Return the depth (T,) that a constant force wears at the steady rate over distances."""
        return (self.load.force or 0.0) * self.running_in.steady.wear_rate * distances

    def remainder(self, depth: Array, force: Array) -> Array:
        """Return the remaining change to the steady state at T times.

        Under a force it is ``d(t) - w t`` minus its limit, with the steady wear rate w; it may
        change its sign. At a fixed indentation it is the force.

        Parameters
        ----------
        depth : (T,) array
            Indentation less the even wear.
        force : (T,) array
            Force.
        """
        if self.load.force is None:
            return force
        steady = self.running_in.steady
        limit = steady.pressure @ (self.load.force * steady.moments + self.moments)
        return depth - limit
