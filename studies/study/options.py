"""Options of a study."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from skfem import Element, Mesh


Quantity: TypeAlias = Callable[..., float]
"""A function that takes the result of a run and returns a number."""
ABSCISSAS = ("size", "unknowns", "seconds")
"""Abscissas of figures of errors: size that theory refers to, number of unknowns, wall time."""


@dataclass(frozen=True)
class Options:
    """Options of a study: what the user chooses besides its name and scene.

    Parameters
    ----------
    quick : whether to conduct a smaller version of the study
    quantities : the user's own quantities: names and functions of the result of a run
    methods : names of the methods to study; empty for the study's own selection
    meshes : the user's mesh files or scikit-fem meshes, from coarse to fine
    degree : polynomial degree of the finite elements on `meshes`
    elements : elements of scikit-fem to study; empty for the study's own selection
    steps : time steps in units of the scene, from coarse to fine
    against : abscissa of the figures, one of `ABSCISSAS`
    """

    quick: bool = False
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    methods: tuple[str, ...] = ()
    meshes: "tuple[str | Mesh, ...]" = ()
    degree: int | None = None
    elements: "tuple[Element, ...]" = ()
    steps: tuple[float, ...] = ()
    against: str = "size"

    @property
    def changed(self) -> list[str]:
        """Names of the options, except `quick`, that differ from their defaults."""
        names = [option.name for option in fields(self) if option.name != "quick"]
        default = Options()
        return [name for name in names if getattr(self, name) != getattr(default, name)]
