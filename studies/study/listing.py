"""List of the studies: the module, the options and the accepted scenes of each.

A module is imported only when its study is conducted, by a function of this file. It has a function
``conduct(scene, options, record)``, which solves the levels by `Record.solve` and returns a `Study`
with tables, figures and conclusions. `Record.solve` writes each row as soon as its level is solved.
Each conclusion is one sentence. `INTERRUPTED` is one of the conclusions if the study was stopped.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..crosscheck import Scene
    from .levels import Record
    from .options import Options
    from .study import Study

    Conduct = Callable[[Scene, Options, Record], Study]


@dataclass(frozen=True)
class ListedStudy:
    """Where the code of a study is, and which scenes and options it accepts.

    Parameters
    ----------
    load : imports the module of the study, and returns its function `conduct`
    purpose : subject of the study, in one phrase
    seconds : run time of the version for ``--quick`` on a machine of two cores, in seconds
    scene : name of the default scene
    option_names : names of the options that it accepts besides `quick` (`studies/study/options.py`)
    any_punch : whether it accepts any punch, not only flat punches under a force
    radial_wear : whether it accepts a wear coefficient that varies along the radius
    layered : whether it accepts a layered half-space
    """

    load: "Callable[[], Conduct]"
    purpose: str
    seconds: int
    scene: str = "five_rings"
    option_names: tuple[str, ...] = ()
    any_punch: bool = False
    radial_wear: bool = False
    layered: bool = False

    @property
    def conduct(self) -> "Conduct":
        """The function ``conduct(scene, options, record)`` of the study, imported at first use."""
        return self.load()


def _paper() -> "Conduct":
    from ..paper.study import conduct

    return conduct


def _convergence() -> "Conduct":
    from ..convergence.study import conduct

    return conduct


def _truncation() -> "Conduct":
    from ..numerics.truncation import conduct

    return conduct


def _march() -> "Conduct":
    from ..numerics.march import conduct

    return conduct


def _refinement() -> "Conduct":
    from ..refinement.study import conduct

    return conduct


def _elements() -> "Conduct":
    from ..elements.study import conduct

    return conduct


def _extremes() -> "Conduct":
    from ..extremes.study import conduct

    return conduct


def _tradeoff() -> "Conduct":
    from ..tradeoff.study import conduct

    return conduct


STUDIES: dict[str, ListedStudy] = {
    "paper": ListedStudy(
        _paper,
        "the whole paper: Figs. 4 to 7 redrawn, its claims checked, and its open questions",
        30,
    ),
    "convergence": ListedStudy(
        _convergence,
        "orders of convergence of every quantity in element size and degree, compared with theory",
        24,
        option_names=("quantities", "methods", "meshes", "degree", "elements", "steps", "against"),
        any_punch=True,
        radial_wear=True,
    ),
    "truncation": ListedStudy(
        _truncation,
        "errors due to the outer boundary, for every far field and Poisson's ratio",
        3,
        radial_wear=True,
        layered=True,
    ),
    "march": ListedStudy(
        _march,
        "orders of the time marches, and the stability limit of the explicit one",
        2,
        option_names=("steps",),
        radial_wear=True,
    ),
    "refinement": ListedStudy(
        _refinement,
        "cost of accuracy on uniform, graded, adaptive, layered and your own meshes",
        15,
        option_names=("meshes", "degree"),
        radial_wear=True,
    ),
    "elements": ListedStudy(
        _elements,
        "stable pairs of displacement and pressure spaces: elements of scikit-fem, or your own",
        7,
        option_names=("elements",),
    ),
    "extremes": ListedStudy(
        _extremes,
        "extreme parameters: true over promised errors, of ringwear and a naive solver, and a map",
        25,
    ),
    "tradeoff": ListedStudy(
        _tradeoff,
        "speed against accuracy: tolerance, error estimate and true error of each method and march",
        25,
        option_names=("quantities", "methods"),
        any_punch=True,
        radial_wear=True,
        layered=True,
    ),
}
