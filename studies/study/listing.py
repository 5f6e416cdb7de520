"""List of the studies: the module, the options and the accepted scenes of each.

A module is imported only when its study is conducted. It has a function
``conduct(scene, options, record)``, which solves the levels by `Record.solve` and returns a `Study`
with tables, figures and conclusions. `Record.solve` writes each row as soon as its level is solved.
Each conclusion is one sentence. `INTERRUPTED` is one of the conclusions if the study was stopped.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..scene.scene import Scene
    from .levels import Record
    from .options import Options
    from .study import Study


@dataclass(frozen=True)
class ListedStudy:
    """Where the code of a study is, and which scenes and options it accepts.

    Parameters
    ----------
    module : module with the function `conduct`, relative to `ringwear.studies`
    purpose : subject of the study, in one phrase
    seconds : run time of the version for ``--quick`` on a machine of two cores, in seconds
    scene : name of the default scene
    option_names : names of the options that it accepts besides `quick` (`studies/study/options.py`)
    any_punch : whether it accepts any punch, not only flat punches under a force
    radial_wear : whether it accepts a wear coefficient that varies along the radius
    layered : whether it accepts a layered half-space
    """

    module: str
    purpose: str
    seconds: int
    scene: str = "five_rings"
    option_names: tuple[str, ...] = ()
    any_punch: bool = False
    radial_wear: bool = False
    layered: bool = False

    @property
    def conduct(self) -> "Callable[[Scene, Options, Record], Study]":
        """The function ``conduct(scene, options, record)`` of the module, imported at first use."""
        conduct: Callable[[Scene, Options, Record], Study]
        conduct = import_module(f"ringwear.studies.{self.module}").conduct
        return conduct


STUDIES: dict[str, ListedStudy] = {
    "paper": ListedStudy(
        "paper.study",
        "the whole paper: Figs. 4 to 7 redrawn, its claims checked, and its open questions",
        30,
    ),
    "convergence": ListedStudy(
        "convergence.study",
        "orders of convergence of every quantity in element size and degree, compared with theory",
        24,
        option_names=("quantities", "methods", "meshes", "degree", "elements", "steps", "against"),
        any_punch=True,
        radial_wear=True,
    ),
    "truncation": ListedStudy(
        "numerics.truncation",
        "errors due to the outer boundary, for every far field and Poisson's ratio",
        3,
        radial_wear=True,
        layered=True,
    ),
    "march": ListedStudy(
        "numerics.march",
        "orders of the time marches, and the stability limit of the explicit one",
        2,
        option_names=("steps",),
        radial_wear=True,
    ),
    "refinement": ListedStudy(
        "refinement.study",
        "cost of accuracy on uniform, graded, adaptive, layered and your own meshes",
        15,
        option_names=("meshes", "degree"),
        radial_wear=True,
    ),
    "elements": ListedStudy(
        "elements.study",
        "stable pairs of displacement and pressure spaces: elements of scikit-fem, or your own",
        7,
        option_names=("elements",),
    ),
    "extremes": ListedStudy(
        "extremes.study",
        "extreme parameters: true over promised errors, of ringwear and a naive solver, and a map",
        25,
    ),
    "tradeoff": ListedStudy(
        "tradeoff.study",
        "speed against accuracy: tolerance, error estimate and true error of each method and march",
        25,
        option_names=("quantities", "methods"),
        any_punch=True,
        radial_wear=True,
        layered=True,
    ),
}
