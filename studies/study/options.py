"""What a user asks of a study besides its scene."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from skfem import Element, Mesh


Quantity: TypeAlias = Callable[..., float]
"""A function that takes the result of a run and returns a number."""
ABSCISSAS = ("size", "unknowns", "seconds")
"""What errors can be drawn against: the size of theory, the number of unknowns, or the time."""


@dataclass(frozen=True)
class Options:
    """What a user asks of a study besides its scene.

    Parameters
    ----------
    quick : whether a smaller version will do
    quantities : functions of a result, by what they are called; empty for the study's own
    methods : names of methods, in place of those that the study compares
    meshes : mesh files or scikit-fem meshes, from coarse to fine
    degree : of the finite elements on `meshes`
    elements : elements of scikit-fem, in place of those that the study compares
    steps : in time, in units of the scene, from coarse to fine
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
    def given(self) -> list[str]:
        """Names of what the user has asked for, besides `quick`."""
        names = [option.name for option in fields(self) if option.name != "quick"]
        default = Options()
        return [name for name in names if getattr(self, name) != getattr(default, name)]
