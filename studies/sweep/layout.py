"""What the results of all scenes have in common: variables, their shapes, and the axes beyond those of the sweep."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ringwear.meshes.errors import SceneError
from ringwear.meshes.radial import Array
from ringwear.studies.methods.quantities import ERROR, NORMS, QUANTITIES, error_name
from ringwear.studies.sweep.axes import Sweep
from ringwear.studies.sweep.kept import JUDGED
from ringwear.studies.wear.modes import SHOWN

# what may become of a scene
PENDING, DONE, FAILED = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Variable:
    """A variable of the store: dimensions and shape beyond those of the sweep, and its attributes."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attributes: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Layout:
    """What the results of all scenes have in common.

    Parameters
    ----------
    solvers : methods of any scene
    coordinates : of the dimensions that are not the sweep's, in the scenes' units: name, values
    variables : by name
    """

    solvers: tuple[str, ...]
    coordinates: dict[str, Array]
    variables: dict[str, Variable]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a block has become.

    Parameters
    ----------
    values : of the layout's variables, the first axis running over the scenes of the block
    status, reason : of each scene
    """

    values: dict[str, Array]
    status: Any
    reason: list[str]


def layout(sweep: Sweep) -> Layout:
    """The layout of a sweep.

    Raises
    ------
    SceneError
        if scenes differ in the times or radii that the kept quantities are at
    """
    first = sweep.scene((0,) * len(sweep.axes))
    dims = {dim for name in sweep.keep for dim in QUANTITIES[name].dims}
    keys = {key: values for axis in sweep.axes for key, values in axis.columns.items()}
    if "time" in dims and "wear.times" in keys:
        raise SceneError(f"{sweep.name}: wear.times varies, and {_needing('time', sweep)} is kept: give one list")
    if "radius" in dims and (first.output.radii is None or {"output.radii", "punch.radius"} & set(keys)):
        raise SceneError(f"{sweep.name}: {_needing('radius', sweep)} is kept at radii that all scenes share: give the base "
                         "output.radii, and vary neither them nor punch.radius")  # fmt: skip
    rings = [first.punch.rings or len(first.punch.ring_edges or []), *keys.get("punch.rings", [])]
    rings += [len(edges) for edges in keys.get("punch.ring_edges", [])]
    methods = keys.get("methods", [first.methods])
    coordinates: dict[str, Any] = {
        "time": np.array(first.wear.times, dtype=float),
        "radius": np.array(first.output.radii or [], dtype=float),
        "ring": np.arange(1, max(rings) + 1),
        "mode": np.arange(1, SHOWN + 1),
    }
    solvers = tuple(dict.fromkeys(name for names in methods for name in names))
    sizes = {"solver": len(solvers)} | {dim: len(values) for dim, values in coordinates.items()}
    variables, stated = {}, first.units or "the scene's own consistent units"
    for name in sweep.keep:
        quantity = QUANTITIES[name]
        for label, own, about in (
            (name, quantity.dims, {"long_name": quantity.definition, "units": "1" if quantity.unit == "slope" else stated}),
            (error_name(name), quantity.error_dims, {"long_name": ERROR.format(name, NORMS[quantity.norm]), "units": "1"}),
        ):
            whole = ("solver", *own)
            variables[label] = Variable(whole, tuple(sizes[dim] for dim in whole), about)
    if len(solvers) > 1:
        variables |= {name: Variable((), (), {"long_name": text, "units": "1"}) for name, text in JUDGED.items()}
    return Layout(solvers, {dim: values for dim, values in coordinates.items() if dim in dims}, variables)


def _needing(dim: str, sweep: Sweep) -> str:
    return next(name for name in sweep.keep if dim in QUANTITIES[name].dims)
