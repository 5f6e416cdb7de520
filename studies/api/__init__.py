"""Wear of a ringed punch on an elastic half-space.

It is computed by finite elements, dimensionality reduction and direct integration.

`Scene`
    what is computed: a TOML file or a bundled name, as ``Scene.load("five_rings")``;
    ``scene.changed(accuracy__rtol=1e-6)``
`run`
    compute a scene by every method it names: ``result = run("five_rings")``, then
    ``result.dataset`` (xarray), ``result.answers``, ``result.verdict``, ``result.error(name)``,
    ``result.plot()``, ``result.save(folder)``
`check`
    results of another program against ours: ``check("five_rings", {"abaqus": "abaqus.csv"})``, then
    ``result.verdicts``, ``result.diagnoses`` and all that a run has
`compare`
    two results beside each other: ``compare("five_rings", "results/mine")``, then ``found.table``,
    ``found.verdict``, ``found.figures``
`deck`
    input files of a scene for CalculiX or Abaqus: ``deck("five_rings", "calculix", "folder")``
`load`
    read results that were saved
`plan`
    what a run will be made of and cost, by a coarse probe of it: lines of text
`study`
    a study of convergence, refinement, limits or cost: ``found = study("march", "five_rings")``,
    then ``found.table``, ``found.orders``, ``found.conclusions``, ``found.figures``
`sweep`
    scenes over axes of scene keys, in one labelled dataset
`Result`, `Study`, `Comparison`
    what `run`, `study` and `compare` return
`SceneError`, `RingwearError`
    what they raise: of a scene that cannot be computed, with the remedy; of anything that fails

Examples
--------
>>> from ringwear import run
>>> result = run("five_rings", methods=["direct"])
>>> float(result.dataset.steady_wear_rate.sel(solver="direct"))  # doctest: +ELLIPSIS
0.994718...
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING

from ringwear.studies.scene.scene import Scene

if TYPE_CHECKING:
    from ringwear.meshes.errors import RingwearError, SceneError
    from ringwear.studies.comparison import Comparison, compare
    from ringwear.studies.decks.deck import deck
    from ringwear.studies.predictions.plan import plan
    from ringwear.studies.results import Result, check, load, run
    from ringwear.studies.study.conduct import study
    from ringwear.studies.study.study import Study
    from ringwear.studies.sweep.conduct import sweep

    __version__: str

__all__ = [
    "Comparison",
    "Result",
    "RingwearError",
    "Scene",
    "SceneError",
    "Study",
    "__version__",
    "check",
    "compare",
    "deck",
    "load",
    "plan",
    "run",
    "study",
    "sweep",
]

# a scene alone does not need the numerics that these bring in
_LATER = {
    "Comparison": "ringwear.studies.comparison",
    "compare": "ringwear.studies.comparison",
    "Result": "ringwear.studies.results",
    "Study": "ringwear.studies.study.study",
    "run": "ringwear.studies.results",
    "check": "ringwear.studies.results",
    "load": "ringwear.studies.results",
    "plan": "ringwear.studies.predictions.plan",
    "deck": "ringwear.studies.decks.deck",
    "study": "ringwear.studies.study.conduct",
    "sweep": "ringwear.studies.sweep.conduct",
    "RingwearError": "ringwear.meshes.errors",
    "SceneError": "ringwear.meshes.errors",
}


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> object:
    if name == "__version__":
        return _import_module("ringwear.studies.versions").versions()["ringwear"]
    if name in _LATER:
        return getattr(_import_module(_LATER[name]), name)
    raise AttributeError(_has_no(name))


# what to write in place of names that other packages have
_OTHER_NAMES = {
    **dict.fromkeys(("solve", "simulate", "compute", "Run", "main"), "ringwear.run"),
    **dict.fromkeys(("open", "read", "Results"), "ringwear.load"),
    **dict.fromkeys(("Problem", "Punch", "Model", "Simulation"), "ringwear.Scene"),
    **dict.fromkeys(("scenes", "examples", "bundled"), "`ringwear scenes` on the command line"),
    "mesh": "`ringwear mesh SCENE` on the command line",
    "plot": "ringwear.run(scene).plot()",
}


def _has_no(name: str) -> str:
    """Return what to write in place of a name that the package does not have."""
    from ringwear.studies.scene.explain import nearest

    near = _OTHER_NAMES.get(name) or nearest(name, __all__)
    meant = f"write {near}; " if name in _OTHER_NAMES else f"did you mean {near}? " if near else ""
    return f"module 'ringwear' has no attribute {name!r}: {meant}it has {', '.join(__all__)}"
