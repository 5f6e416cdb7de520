"""Compute the wear of a ringed punch on an elastic half-space.

The methods are finite elements, boundary elements, dimensionality reduction and direct integration.

`Scene`
    the problem, from a TOML file or by a bundled name: ``Scene.load("five_rings")``;
    ``scene.changed(accuracy__rtol=1e-6)``
`run`
    compute a scene by every method it names: ``result = run("five_rings")``, then
    ``result.dataset`` (xarray), ``result.answers``, ``result.verdict``, ``result.error(name)``,
    ``result.plot()``, ``result.save(folder)``
`check`
    compare results of another program with ours: ``check("five_rings", {"abaqus":
    "abaqus.csv"})``, then ``result.verdicts``, ``result.diagnoses`` and all attributes of a run
`compare`
    compare two results: ``comparison = compare("five_rings", "results/mine")``, then
    ``comparison.table``, ``comparison.verdict``, ``comparison.figures``
`deck`
    write input files of a scene for CalculiX or Abaqus: ``deck("five_rings", "calculix",
    "folder")``
`fit`
    determine wear coefficients from measurements: ``result = fit("mine.toml", "data.csv",
    "punch.wear_coefficient")``, then ``result.estimates``, ``result.conclusions``,
    ``result.figures``
`load`
    read saved results
`plan`
    predict sizes and cost of a run by a coarse probe of it; returns lines of text
`study`
    study convergence, refinement, limits or cost: ``results = study("march", "five_rings")``, then
    ``results.table``, ``results.orders``, ``results.conclusions``, ``results.figures``
`sweep`
    compute scenes over axes of scene keys, in one labelled dataset
`Result`, `Study`, `Comparison`
    classes of the results of `run`, `study` and `compare`
`SceneError`, `RingwearError`
    exceptions: a scene cannot be computed (the message contains a remedy); anything else fails

Examples
--------
>>> from ringwear import run
>>> result = run("five_rings", methods=["direct"])
>>> float(result.dataset.steady_wear_rate.sel(solver="direct"))  # doctest: +ELLIPSIS
0.994718...
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING

# from now on, edits of the package's files are noticed
from ringwear.studies import STARTED as _STARTED  # noqa: F401

if TYPE_CHECKING:
    from ringwear.meshes.errors import RingwearError, SceneError
    from ringwear.studies.comparison import Comparison, compare
    from ringwear.studies.decks.deck import deck
    from ringwear.studies.fit.fit import fit
    from ringwear.studies.predictions.plan import plan
    from ringwear.studies.results import Result, check, load, run
    from ringwear.studies.scene.scene import Scene
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
    "fit",
    "load",
    "plan",
    "run",
    "study",
    "sweep",
]

# names that are imported at their first use, because they load other packages; the command line
# can handle an interruption meanwhile
_LATER = {
    "Comparison": "ringwear.studies.comparison",
    "compare": "ringwear.studies.comparison",
    "Result": "ringwear.studies.results",
    "Scene": "ringwear.studies.scene.scene",
    "Study": "ringwear.studies.study.study",
    "run": "ringwear.studies.results",
    "check": "ringwear.studies.results",
    "fit": "ringwear.studies.fit.fit",
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


# what to write instead of names that other packages use
_OTHER_NAMES = {
    **dict.fromkeys(("solve", "simulate", "compute", "Run", "main"), "ringwear.run"),
    **dict.fromkeys(("open", "read", "Results"), "ringwear.load"),
    **dict.fromkeys(("Problem", "Punch", "Model", "Simulation"), "ringwear.Scene"),
    **dict.fromkeys(("scenes", "examples", "bundled"), "`ringwear scenes` on the command line"),
    **dict.fromkeys(("list_scenes", "bundled_scenes"), "`ringwear scenes` on the command line"),
    **dict.fromkeys(("run_scene", "run_file"), "ringwear.run"),
    **dict.fromkeys(("validate", "predict"), "ringwear.plan"),
    "mesh": "`ringwear mesh SCENE` on the command line",
    "challenge": "`ringwear challenge` on the command line",
    "template": "`ringwear check SCENE --template DIR` on the command line",
    "cli": "`ringwear` on the command line",
    "plot": "ringwear.run(scene).plot()",
}


def _has_no(name: str) -> str:
    """Return the error message for a name that the package does not have."""
    from ringwear.studies.scene.explain import nearest

    suggestion = _OTHER_NAMES.get(name) or nearest(name, __all__)
    hint = f"did you mean {suggestion}? " if suggestion else ""
    if name in _OTHER_NAMES:
        hint = f"write {suggestion}; "
    return f"module 'ringwear' has no attribute {name!r}: {hint}it has {', '.join(__all__)}"
