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
    compare results of another program with ours: ``found = check("five_rings", {"abaqus":
    "abaqus.csv"})``, then ``found.errors``, ``found.passes``, ``found.mistakes()``, and
    ``found.result`` (ours)
`compare`
    compare two results: ``comparison = compare("five_rings", "results/mine")``, then
    ``comparison.table``, ``comparison.same``, ``comparison.figures``
`compare_operators`
    compare the elastic energies that methods assign to every pressure: ``(pair,) =
    compare_operators("five_rings", ["fem", "mdr"])``, then ``pair.rings``, ``pair.history``
`deck`
    write input files of a scene for CalculiX or Abaqus: ``deck("five_rings", "calculix",
    "folder")``
`fit`
    determine wear coefficients from measurements: ``result = fit("mine.toml", "data.csv",
    "punch.wear_coefficient")``, then ``result.estimates``, ``result.conclusions``,
    ``result.figures``
`load`
    read saved results
`orders`
    fit orders of convergence to any table of levels: ``orders(table, by="h")``
`plan`
    predict sizes and cost of a run by a coarse probe of it; or, with ``size`` or ``mesh``, the
    longest stable update of wear on the mesh of another program; returns lines of text
`study`
    study convergence, refinement, limits or cost: ``results = study("march", "five_rings")``, then
    ``results.table``, ``results.orders``, ``results.conclusions``, ``results.figures``
`sweep`
    compute scenes over axes of scene keys, in one labelled dataset
`Result`, `Study`, `Comparison`, `Check`
    classes of the results of `run`, `study`, `compare` and `check`
`SceneError`, `MeshError`, `SolverError`, `RingwearError`
    exceptions: a scene cannot be computed (the message contains a remedy); a mesh is missing or
    broken; a system of equations has no meaningful solution; base of these and of all others
`main`
    run the command line, with the arguments as a list; returns the exit status

What runs are built of, for a method or a study of one's own. All of it is non-dimensional: lengths
in punch radii, forces in units of that which gives a flat punch the indentation 1/2.

`PressureSpace`, `ContactCells`, `Compliance`
    polynomials along the radius that represent pressures; cells of the face; what turns pressures
    into displacements
`energy`, `ring_kernel`, `even_half_space`
    compliances by the MDR energy, by boundary elements, and by finite elements
`direct`
    closed forms for pressures that are constant on each ring
`Problem`, `Rings`, `InitialProfile`, `Loading`, `Ground`
    a scene without units (``Scene.problem``), and its parts: rings, unworn face, load over time,
    elastic layers
`press_flat`, `moments`, `Load`, `RunningIn`
    a flat punch that is pressed; integrals of a face; a force or an indentation; wear in full
    contact, exact in time
`WearingPunch`, `evolve`, `evolve_in_equal_steps`
    a punch that wears while contact opens and spreads; its wear at any time, in steps that follow a
    tolerance, or in equal steps
`Method`, `ComplianceMethod`, `Discretised`, `pressure_spaces`, `Solution`, `method`, `Stages`
    a method, and one that only computes a compliance; the half-space it discretises; the space that
    resolves a problem, and a coarser one; what a method has solved; the bundled method of a name;
    its seconds by stage
`differences`
    relative differences of two sets of results, each in the norm of its quantity
`SizeField`, `bisection`, `ring_areas`, `alternating_edges`
    sizes of elements; meshes without gmsh; areas of rings; rings whose widths alternate

Examples
--------
>>> from ringwear import run
>>> result = run("five_rings", methods=["direct"])
>>> float(result.dataset.steady_wear_rate.sel(solver="direct"))  # doctest: +ELLIPSIS
0.994718...

That rate without units by what runs are built of. It is the same on every ring:

>>> import numpy as np
>>> from ringwear import PressureSpace, RunningIn, Scene, direct, energy
>>> rings = Scene.load("five_rings").problem.merged
>>> edges, (coefficients, _) = rings  # the coefficients are constant on each ring
>>> float((coefficients * direct.steady_pressures(edges, coefficients))[0])  # doctest: +ELLIPSIS
0.0497359...
>>> space = PressureSpace(edges, np.full(len(rings.widths), 8), edges)
>>> wear = RunningIn(energy.compliance(space), coefficients)
>>> float(wear.steady.wear_rate)  # doctest: +ELLIPSIS
0.0497359...

Half-spaces by different theories have the same compliance; here, one by finite elements:

>>> from ringwear import ContactCells, even_half_space, press_flat
>>> cells = ContactCells((0.0, 1.0), 0.1, 0.01)
>>> pressed = press_flat(even_half_space(cells).compliance())
>>> abs(pressed.indentation - 0.5) < 1e-3
True
"""

import lazy_loader as _lazy

# from now on, edits of the package's files are noticed
from ringwear.studies import STARTED as _STARTED  # noqa: F401

# the names in the stub `__init__.pyi`; the file of a name is loaded at its first use, because it
# loads other packages; the command line can handle an interruption meanwhile
_load, _, __all__ = _lazy.attach_stub(__name__, __file__)
__all__ += ["__version__"]


def __dir__() -> list[str]:
    return __all__


# names that users need first
_FIRST = (
    *("Scene", "run", "check", "compare", "deck", "fit", "load", "plan", "study", "sweep"),
    *("Result", "Study", "Comparison", "Check", "RingwearError", "SceneError"),
)


def __getattr__(name: str) -> object:
    from ringwear.studies.crosscheck import did_you_mean, package_versions

    if name == "__version__":
        return package_versions()["ringwear"]
    if name in __all__:
        return _load(name)
    hint = did_you_mean(name, __all__, f"it has {', '.join(_FIRST)}", "")
    raise AttributeError(f"module 'ringwear' has no attribute {name!r}{hint}")
