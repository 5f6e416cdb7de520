"""Describe the longest stable updates of a scene on a mesh in words."""

from .elements import CONSISTENT, PER_NODE
from .limits import STEP_ERROR, StepLimits, sides_of

RECOMMENDED = 0.5
"""Recommended step over the longest stable one: pressures then err by 1 to 4 % (`ringwear study
march`)."""
LOCKING = 0.45
"""Poisson's ratio above which the note on locking is added."""


def describe(found: list[StepLimits]) -> list[str]:
    """Return the lines about the longest stable updates.

    Parameters
    ----------
    found : limits on a mesh of the user; or on several meshes of one size, the usual one first
    """
    limits = found[0]
    scene, names = limits.scene, limits.scene.unit_names
    ratio = scene.problem.ground.greatest_poisson_ratio
    count, least, greatest = sides_of(limits.nodes)
    ends = [names.write(end * scene.problem.units.length, "length", 3) for end in (least, greatest)]
    sides = f"{ends[0]} each" if greatest < least * 1.001 else f"{ends[0]} to {ends[1]}"
    lines = [
        f"mesh: {count} sides of {limits.nodes.element} on the contact, {sides}; limits are for "
        f"full integration and Poisson's ratio {ratio:g}",
        f"stable: at most {written(limits, limits.limit())} per update, if pressures are forces "
        "over the areas of nodes; at most "
        f"{written(limits, limits.limit(CONSISTENT))} with a consistent mass matrix",
    ]
    if len(limits.contacts) > 1:
        states = (
            f"{written(limits, contact.limit(PER_NODE))} {contact.name}"
            for contact in limits.contacts
        )
        lines.append(f"contact: edges move; {', '.join(states)}")
    recommended = RECOMMENDED * limits.limit()
    lines.append(f"recommended: half of it, {written(limits, recommended)}{_updates(limits)}")
    lines += _accuracy(limits)
    if len(found) > 1:
        least, greatest = (end(each.limit() for each in found) for end in (min, max))
        lines.append(
            f"range: {written(limits, least)} to {written(limits, greatest)} on {len(found)} "
            "meshes of this size, with first rows from half to twice as thick, and triangles in "
            "rows or free; other meshes may differ more: --mesh FILE gives the limit of yours"
        )
    if ratio > LOCKING:
        lines.append(
            f"note: at Poisson's ratio {ratio:g} elements with full integration are too stiff, "
            "which shortens the stable step up to fivefold; selective or reduced integration "
            "(B-bar, CAX8R, hybrid elements) does not have this effect"
        )
    edges = scene.problem.merged.ring_edges
    if len(edges) > 2:
        lines.append(
            "note: nodes on ring edges have the harmonic mean of both wear coefficients, with "
            "which their pressures err least"
        )
    return lines


def written(limits: StepLimits, step: float) -> str:
    """Return a step as text: a sliding distance, and a time if speed is constant."""
    scene, names = limits.scene, limits.scene.unit_names
    units, load = scene.problem.units, scene.load_
    distance = names.write(limits.distance(step), "distance", 3)
    if load.times_are_distances or scene.problem.loading.varies:
        return f"a sliding distance of {distance}"
    return (
        f"a sliding distance of {distance} (a time of {names.write(step * units.time, 'time', 3)})"
    )


def _updates(limits: StepLimits) -> str:
    count = limits.updates_of_running_in / RECOMMENDED
    if not count < float("inf"):
        return ""
    return f": {max(round(count), 1)} updates until 99 % of the running-in"


def _accuracy(limits: StepLimits) -> list[str]:
    """Return a line on the steps with a given error; none if edges of the contact move."""
    parts = limits.accurate_steps
    if not parts:
        return []
    texts = [
        f"{name} by {written(limits, part * limits.limit())}"
        if part
        else f"{name} by less than a thousandth of the stable step"
        for name, part in parts.items()
    ]
    earliest = limits.scene.problem.earliest or 0.0
    since = limits.scene.unit_names.write(earliest * limits.scene.problem.units.time, "time", 3)
    after = f" from {since} on" if earliest else ""
    error = f"an error of {STEP_ERROR:.0%} by the steps{after}"
    return [f"accuracy: {error} is caused in {'; '.join(texts)}"]
