"""What a method hands up for a scene: its compliance, and the coarser twins that its error is estimated from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from ringwear.meshes.compliance import Compliance

if TYPE_CHECKING:
    from ringwear.fem.half_space import HalfSpace


@dataclass(frozen=True, eq=False)
class Twin:
    """A pair whose difference estimates one part of the error.

    Parameters
    ----------
    part : what differs
    finer, coarser : the pair
    share : how much of the difference is counted for indentations, which converge twice as fast
    field_share : the same for everything else
    other_mesh : whether the pair differ in their meshes, too, and so tell what projections on the pressure space lose
    """

    part: str
    finer: Compliance
    coarser: Compliance
    share: float
    field_share: float
    other_mesh: bool = False


@dataclass(frozen=True, eq=False)
class Model:
    """A method made ready for a scene.

    Parameters
    ----------
    compliance : on the method's own pressure space
    twins : for the error estimate
    unknowns : size of the system behind the compliance
    settings : the sizes chosen, for the summary
    half_space : the finite-element half-space, if there is one
    notes : remarks for the summary, such as a mesher replaced
    """

    compliance: Compliance
    twins: tuple[Twin, ...]
    unknowns: int
    settings: dict[str, object]
    half_space: HalfSpace | None = None
    notes: tuple[str, ...] = ()

    @property
    def rim_size(self) -> float:
        """Size of the element at the rim."""
        return float(np.diff(self.compliance.space.breakpoints)[-1])

    @property
    def rim_cost(self) -> float:
        """Share of d0 that the element at the rim costs, whatever the rest: it cannot hold a pressure that is infinite.

        Measured per size of the element, for pressures of degree 1, 2, 4 and 7 on it: 0.05, 0.023, 0.009 and 0.004.
        """
        return 0.055 / int(self.compliance.space.degrees[-1]) * self.rim_size
