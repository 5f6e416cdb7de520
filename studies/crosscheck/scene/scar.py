"""Choose the radius of a punch whose scar goes on growing, if the scene does not give it.

A ball, a cone or a parabola of one material has no rim that matters: the face must only be wider
than its contact ever gets. Contact ends at the radius a where wear ends, so that the worn volume is

    V = int (f(a) - f(r)) dA - int (u(r) - u(a)) dA        over the contact,

with the unworn height f and the displacement u of the half-space. The second integral is bounded,
because wear flattens the pressure: it is greatest at the start, and then at most ``2/3 F a / E*``
on a homogeneous half-space, the value of a cone (a ball: 3 pi / 16). On thin layers, which yield
only where they are pressed, it is ``pi/2 F a / E*`` with the modulus that a flat punch of radius a
would feel, or with a smaller one. At a fixed indentation d, contact ends at the latest where
f(a) = d.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError
from scipy.optimize import brentq

from ....meshes.errors import SceneError
from ....meshes.ground.line_energy import uniform_energy
from ....meshes.radial import unit_gauss
from ..problem.fields import TomlTable
from ..problem.loading import Loading
from ..problem.punch import PunchSection
from ..problem.sections import HalfSpaceSection, LoadSection, WearSection

GROWING = ("ball", "cone", "parabola")
# bounds of the integral of the displacements over F a / E*: on a half-space, and on any layers
OF_HALF_SPACE, OF_LAYERS = 2 / 3, np.pi / 2
# radius of the face over the bound of the contact radius
MARGIN = 1.2
# ratio of the radii that bracket that bound
STEP = 1.2
# a radius that only lets other keys of the punch be checked
PRELIMINARY = 1e-30
POINTS = 24


def with_scar_radius(table: Mapping[str, Any]) -> TomlTable:
    """Return a scene's table with a punch radius that is wider than the contact gets.

    The table stays as it is if it has the radius, or if its punch is of another kind. If other keys
    are wrong, the radius is preliminary, and the scene reports them.

    Raises
    ------
    SceneError
        if other keys need the radius, or if the scar becomes wider than the ball
    """
    punch, load, wear = (table.get(name, {}) for name in ("punch", "load", "wear"))
    if not all(isinstance(each, Mapping) for each in (punch, load, wear)) or "radius" in punch:
        return dict(table)
    profile = punch.get("profile")
    if not isinstance(profile, Mapping) or profile.get("kind") not in GROWING:
        return dict(table)
    try:
        radius = _scar_radius(
            PunchSection(**punch, radius=PRELIMINARY),
            HalfSpaceSection(**table["half_space"]),
            LoadSection(**load),
            WearSection(**wear),
        )
    except (ValidationError, KeyError, TypeError):
        radius = PRELIMINARY
    return {**table, "punch": {**punch, "radius": radius}}


def _scar_radius(
    punch: PunchSection, ground: HalfSpaceSection, load: LoadSection, wear: WearSection
) -> float:
    """Return a radius that is greater than that of the contact at any time until the last."""
    needing = {
        "other keys of punch": punch.model_fields_set
        - {"radius", "profile", "wear_coefficient", "wear_coefficients"},
        "several wear coefficients": punch.table or len(punch.coefficients) > 1,
        "load.mean_pressure": load.mean_pressure,
        "wear.times by running-in": wear.tau,
        "a scene without wear.times": not wear.times,
    }
    if needing := {name: each for name, each in needing.items() if each}:
        raise SceneError(
            f"missing key punch.radius; give the punch radius, because of {', '.join(needing)}. "
            f"Only a {', '.join(GROWING)} of one material under a normal_force or an indentation "
            "can do without: its face is as wide as the contact gets by the last of wear.times"
        )
    assert punch.profile is not None
    height = punch.profile.height_over(1.0)
    widest = getattr(punch.profile, "ball_radius", np.inf)
    force, volume = load.greatest_force(1.0, 0.0), 0.0
    if load.indentation is None:
        speed = load.speed_over_time
        last = np.array((load.cycle_ends if wear.each_cycle else wear.times)[-1:])
        work = Loading.over_time(load.load_over_time, speed, 1.0).at(last).work
        volume = punch.coefficients[0] * force * speed.greatest * float(work[0])
    node, weight = unit_gauss(POINTS)

    def excess(radius: float) -> float:
        """Return the greatest volume of a scar of that radius, less that of wear and elasticity."""
        rim = float(height(np.array(radius)))
        if load.indentation is not None:
            return rim - load.indentation
        inside = float(2 * np.pi * radius**2 * (rim - height(radius * node)) @ (weight * node))
        compliance, part = 1 / ground.modulus, OF_HALF_SPACE
        if ground.layers:
            part = OF_LAYERS
            compliance *= uniform_energy(ground.ground(radius))
        return inside - volume - part * force * radius * compliance

    # bracket the radius in small steps, from one at which layers are not thin: on a much wider face
    # they would be too thin
    outer = min(ground.layers[0].thickness if ground.layers else 1.0, widest)
    while outer < widest and excess(outer) < 0:
        outer = min(STEP * outer, widest)
    if excess(outer) < 0:
        raise SceneError(
            f"the scar becomes wider than the ball, whose radius is {widest:g}: give earlier "
            "wear.times, or a smaller load"
        )
    inner = outer / STEP
    while excess(inner) > 0:
        outer, inner = inner, inner / STEP
    bound = float(brentq(excess, inner, outer, rtol=1e-3))
    return min(MARGIN * bound, widest)
