"""The studies by name: where each is, and what it takes. Nothing is imported until it is used.

A study is a file with a function ``conduct(scene, options, record)``: it solves its levels on the
record, which writes each row as it comes, and returns a `Study` with tables, figures and
conclusions, a sentence each; `INTERRUPTED` is among them if it was stopped.
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
    """A study before it is conducted.

    Parameters
    ----------
    module : the module that conducts it, relative to `ringwear.studies`
    purpose : what it studies
    seconds : that `--quick` takes
    scene : its scene by default
    takes : names of the options that it knows besides `quick` (`studies/study/conduct.py`)
    of_any_punch : whether it takes any punch
    along_radius : whether it takes wear that varies along the radius
    of_layers : whether it takes layered ground
    """

    module: str
    purpose: str
    seconds: int
    scene: str = "five_rings"
    takes: tuple[str, ...] = ()
    of_any_punch: bool = False
    along_radius: bool = False
    of_layers: bool = False

    @property
    def conduct(self) -> "Callable[[Scene, Options, Record], Study]":
        """The function ``conduct(scene, options, record)`` of the module, imported at first use."""
        conduct: Callable[[Scene, Options, Record], Study]
        conduct = import_module(f"ringwear.studies.{self.module}").conduct
        return conduct


STUDIES: dict[str, ListedStudy] = {
    "paper": ListedStudy(
        "paper.study",
        "the whole paper again: Figs. 4 to 7 redrawn, its claims checked, and what it leaves open",
        30,
    ),
    "convergence": ListedStudy(
        "convergence.study",
        "orders of convergence of every quantity, in element size and degree, beside theory",
        24,
        takes=("quantities", "methods", "meshes", "degree", "elements", "steps", "against"),
        of_any_punch=True,
        along_radius=True,
    ),
    "truncation": ListedStudy(
        "numerics.truncation",
        "what the outer boundary costs, for every far field and Poisson's ratio",
        3,
        along_radius=True,
        of_layers=True,
    ),
    "march": ListedStudy(
        "numerics.march",
        "orders of the time marches, and where the explicit one blows up",
        2,
        takes=("steps",),
        along_radius=True,
    ),
    "refinement": ListedStudy(
        "refinement.study",
        "uniform, graded, adaptive and layered meshes, and meshes of your own: what accuracy costs",
        15,
        takes=("meshes", "degree"),
        along_radius=True,
    ),
    "elements": ListedStudy(
        "elements.study",
        "which pair of displacement and pressure is stable, by scikit-fem's elements or your own",
        7,
        takes=("elements",),
    ),
    "extremes": ListedStudy(
        "extremes.study",
        "extreme parameters: true errors over promised ones beside a naive solver, and a map",
        25,
    ),
    "tradeoff": ListedStudy(
        "tradeoff.study",
        "speed against accuracy: tolerance, estimate and true error of every method and march",
        25,
        takes=("quantities", "methods"),
        of_any_punch=True,
        along_radius=True,
        of_layers=True,
    ),
}
