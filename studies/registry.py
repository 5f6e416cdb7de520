"""The methods and the studies by name.

Where each is, and what a study takes. Nothing is imported until it is used.

A method is a file with an object ``METHOD`` (`studies/methods/base.py`). A study is a file with a
function ``conduct(scene, out, options)``: it writes its figures and tables to the directory `out`
and returns its conclusions, a line each; `INTERRUPTED` is among them if it was stopped.
"""

from argparse import ArgumentTypeError
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any


def name_of_file(text: str) -> str:
    """Return what refuses an option without text."""
    if not text.strip():
        raise ArgumentTypeError("is empty: give a file")
    return text


METHODS = ("mdr", "mdr-grid", "bem", "direct", "fem")
INTERRUPTED = "INTERRUPTED: tables and figures hold the rows that were finished."


@dataclass(frozen=True)
class Study:
    """A study, as the command line uses it.

    Parameters
    ----------
    module : the module that conducts it, relative to `ringwear.studies`
    purpose : what it studies
    seconds : that `--quick` takes
    scene : its scene by default
    options : its own options and the arguments of `add_argument` for each
    of_any_punch : whether it takes any punch
    of_shaped_punches : whether it takes shaped punches, too, not only flat ones under a force
    """

    module: str
    purpose: str
    seconds: int
    scene: str = "five_rings"
    options: tuple[tuple[str, dict[str, Any]], ...] = ()
    of_any_punch: bool = False
    of_shaped_punches: bool = False

    @property
    def conduct(self) -> Callable[..., list[str]]:
        """The function ``conduct(scene, out, options)`` of the module, imported at first use."""
        return import_module(f"ringwear.studies.{self.module}").conduct


STUDIES: dict[str, Study] = {
    "paper": Study(
        "paper.study",
        "the whole paper again: Figs. 4 to 7 redrawn, its claims checked, and what it leaves open",
        30,
    ),
    "convergence": Study(
        "numerics.convergence",
        "orders of convergence in element size and degree, graded and uniform",
        10,
        of_shaped_punches=True,
    ),
    "truncation": Study(
        "numerics.truncation",
        "what the outer boundary costs, for every far field and Poisson's ratio",
        3,
    ),
    "march": Study(
        "numerics.march", "orders of the time marches, and where the explicit one blows up", 2
    ),
    "refinement": Study(
        "numerics.refinement",
        "uniform and graded meshes, and a mesh file of your own, against what is known",
        7,
        options=(
            (
                "--mesh",
                {
                    "type": name_of_file,
                    "metavar": "FILE",
                    "help": "a mesh file of yours: .msh of gmsh, .vtu, ...",
                },
            ),
        ),
    ),
    "extremes": Study(
        "numerics.extremes",
        "a map of the limits: every method at extreme parameters against closed forms",
        55,
    ),
    "tradeoff": Study(
        "numerics.tradeoff",
        "error of groups of quantities against seconds, for every method",
        18,
        of_any_punch=True,
    ),
}
