"""Wear of a ringed punch on an elastic half-space, by finite elements, dimensionality reduction and
direct integration.

`Scene`
    what is computed: a TOML file or a bundled name, as ``Scene.load("five_rings")``;
    ``scene.changed(accuracy__rtol=1e-6)``
`run`
    compute a scene by every method it names: ``result = run(scene)``, then ``result.dataset``
    (xarray), ``result.answers``, ``result.verdict_in_words``, ``result.summary``
`plan`
    what a run will be made of and cost, by a coarse probe of it: lines of text

Examples
--------
>>> from ringwear import Scene, run
>>> result = run(Scene.load("five_rings").changed(methods=["direct"]))
>>> float(result.dataset.steady_wear_rate.sel(solver="direct"))  # doctest: +ELLIPSIS
0.994718...
"""

from importlib import import_module
from typing import TYPE_CHECKING

from ringwear.studies.problem.scene import Scene

if TYPE_CHECKING:
    from ringwear.studies.crosscheck.plan import plan
    from ringwear.studies.crosscheck.run import run
    from ringwear.studies.sweep.conduct import sweep

__all__ = ["Scene", "plan", "run", "sweep"]

# a scene alone does not need the numerics that these bring in
LATER = {
    "run": "ringwear.studies.crosscheck.run",
    "plan": "ringwear.studies.crosscheck.plan",
    "sweep": "ringwear.studies.sweep.conduct",
}


def __getattr__(name: str) -> object:
    if name in LATER:
        return getattr(import_module(LATER[name]), name)
    raise AttributeError(f"module 'ringwear' has no attribute {name!r}")
