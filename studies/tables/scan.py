"""Read the profile of a punch from a scan: heights along a line, or on a map.

A scan has two columns, positions and heights, or three, x, y and heights. A line may run along a
radius or over a whole diameter. Values that are no numbers are left out and counted. What is done
to a scan, and what is only guessed, is in its notes.
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...meshes import Array, SceneError
from .circles import ROUNDOFF, on_circles
from .frame import HEAD, Frame
from .headings import name_of, split_heading
from .layout import content_of_file, text_of

UNIT_LINE = re.compile(
    r"^.*\bunits?\b.*[:=,;\t ]\W*([nuµμmc]?m|micro\w+|in|inch)\b.*$", re.I | re.M
)
"""A line above the numbers that states a unit of length."""
SLOPE_KEPT = 0.05
"""A slope at the axis is mentioned if it makes this part of all height differences."""
POWERS = (0, 1, 2, 4, 6)
"""Powers of the radius of which the slope at the axis is one, in a fit of a scan along a radius."""


class Scan(NamedTuple):
    """The profile of a punch: heights over the radius.

    Parameters
    ----------
    radii, heights : (R,) increasing radii, and heights from the lowest point if some were negative
    units : of the radii and of the heights, as the file has them; empty if it has none
    notes : what was done to the scan
    """

    radii: Array
    heights: Array
    units: tuple[str, str]
    notes: tuple[str, ...]


def read_scan(path: Path, center: bool = False, level: bool = False) -> Scan:
    """Read a scan of a punch.

    Parameters
    ----------
    path : text file of two columns (positions and heights) or three (x, y and heights)
    center : whether the axis is found in the scan: at its lowest or highest point or, if it is
        levelled as well, in its middle; otherwise it is at the position 0
    level : whether offset and tilt are removed

    Raises
    ------
    SceneError
        if the file has other columns, or too few numbers
    """
    frame = Frame.of_file(path, headed=False)
    columns = _columns(frame)
    units = [frame.units.get(each, "") for each in columns]
    if any(units) and not all(units):
        raise SceneError(
            f"{path} has units at some columns only ({', '.join(columns)}): give one at each, as "
            "in x [mm], z [um]"
        )
    elsewhere = UNIT_LINE.search(text_of(content_of_file(path, HEAD), path))
    if elsewhere and not any(units):
        raise SceneError(
            f"{path} has a unit outside of its headings, {elsewhere[0].strip()!r}: give one in "
            "each heading, as in x [mm], z [um]"
        )
    frame.refuse_faults(dict(zip(columns, columns, strict=True)))
    numbers = frame.values[columns].to_numpy(dtype=float)
    known, notes = np.isfinite(numbers).all(axis=1), list[str]()
    heading = columns[-1]
    if "depth" in heading.lower():
        notes.append(f"{heading} is read as the depth of missing material, not as a height below 0")
    if not known.all():
        notes.append(f"{np.count_nonzero(~known)} of {len(known)} values left out: no numbers")
    numbers = numbers[known]
    if len(numbers) < 2:
        raise SceneError(
            f"{path} has {len(numbers)} rows of numbers: give at least two, position and height"
        )
    heights = numbers[:, -1]
    constant = [number for number in range(numbers.shape[1] - 1) if not np.ptp(numbers[:, number])]
    if numbers.shape[1] == 3 and len(constant) == 1:
        across = constant[0]
        notes.append(f"a line, because {columns[across]} is {numbers[0, across]:g} everywhere")
        numbers = np.delete(numbers, across, axis=1)
    if numbers.shape[1] == 3:
        radii, heights = _of_map(numbers[:, :2], heights, center, level, notes)
    elif len(np.unique(numbers[:, 0])) <= len(numbers) / 2:
        raise SceneError(f"{path} has each position twice or more: give each curve in a file")
    else:
        radii, heights = _of_line(numbers[:, 0], heights, center, level, notes)
    if level or heights.min() < 0:
        heights = heights - heights.min()
    return Scan(radii, heights, (units[0], units[-1]), tuple(notes))


def _columns(frame: Frame) -> list[str]:
    """Return the headings of the columns of positions, one or two, and of heights."""
    headings = [heading for heading in frame.cells if frame.cells[heading].ne("").any()]
    names = [split_heading(heading).name for heading in headings]
    positions = _known(headings, ("radius", "position"))
    heights = _known(headings, ("height",))
    if len(headings) == 2:
        swapped = heights == headings[:1] and positions == headings[1:]
        return headings[::-1] if swapped else headings
    if len(headings) == 3 and (names[0].isdigit() or names[:2] == ["x", "y"]):
        return headings
    if {"x", "y"} <= set(names) and heights and split_heading(heights[0]).name != "y":
        return [headings[names.index("x")], headings[names.index("y")], heights[0]]
    if len(positions) == 1 and len(heights) == 1:
        return [positions[0], heights[0]]
    listed = ", ".join(headings) if len(headings) > 1 else "one"
    raise SceneError(
        f"{frame.name} has the columns {listed}: give two, radius and height, or three, x, y and "
        "height"
    )


def _known(headings: list[str], wanted: tuple[str, ...]) -> list[str]:
    """Return the headings of a quantity, only those that are the most usual."""
    found = [(pair[0], heading) for heading in headings if (pair := name_of(heading, wanted))]
    least = min((place for place, _ in found), default=0)
    return [heading for place, heading in found if place == least]


def _of_line(
    positions: Array, heights: Array, center: bool, level: bool, notes: list[str]
) -> tuple[Array, Array]:
    """Return radii and heights of a scan along a line."""
    order = np.argsort(positions, kind="stable")
    positions, heights = positions[order], heights[order]
    if center:
        middle = _vertex(positions, heights, level)
        positions = positions - middle
        notes.append(f"the axis is at the position {middle:.6g} of the scan")
    # a position at the axis that is not 0 by roundoff
    positions = np.where(np.abs(positions) < ROUNDOFF * np.ptp(positions), 0.0, positions)
    if positions[0] >= 0:
        return positions, _leveled_radius(positions, heights, level, notes)
    if positions[-1] <= 0:
        return -positions[::-1], _leveled_radius(-positions[::-1], heights[::-1], level, notes)
    # over a diameter, the tilt is the part that differs between the halves
    grid: Array = np.unique(np.round(np.abs(positions), 12))
    reach = min(positions[-1], -positions[0]) * (1 + 1e-9)
    halves: list[Array] = [
        np.interp(grid, side[0], side[1], right=np.nan)
        for side in (
            (positions[positions >= 0], heights[positions >= 0]),
            (-positions[positions <= 0][::-1], heights[positions <= 0][::-1]),
        )
    ]
    halves = [np.where(np.isnan(half), other, half) for half, other in (halves, halves[::-1])]
    both, difference = grid <= reach, (halves[0] - halves[1]) / 2
    if level:
        tilt = float(grid[both] @ difference[both] / (grid[both] @ grid[both]))
        notes.append(f"a tilt of {tilt:.3g} was removed")
        halves = [halves[0] - tilt * grid, halves[1] + tilt * grid]
    mean = (halves[0] + halves[1]) / 2
    apart = float(np.abs(halves[0] - halves[1])[both].max())
    notes.append(f"a scan over the diameter: its halves differ by up to {apart:.3g}")
    return _with_axis(grid, mean)


def _of_map(
    places: Array, heights: Array, center: bool, level: bool, notes: list[str]
) -> tuple[Array, Array]:
    """Return radii and mean heights on circles of a map."""
    middle: Array = np.zeros(2)
    if center:
        middle = (places.max(axis=0) + places.min(axis=0)) / 2
        tilt, square = _paraboloid(places, heights)
        if square and not level:
            middle = -tilt / (2 * square)
        notes.append(f"the axis is at x = {middle[0]:.6g}, y = {middle[1]:.6g} of the map")
    if level:
        tilt, _ = _paraboloid(places - middle, heights)
        heights = heights - (places - middle) @ tilt
        notes.append(f"tilts of {tilt[0]:.3g} and {tilt[1]:.3g} were removed")
    shifted_x, shifted_y = (places - middle).T
    radii, means, spread = on_circles(shifted_x, shifted_y, heights)
    notes.append(
        f"a map: means over {len(radii)} circles around the axis, on which heights differ by up to "
        f"{spread:.3g}"
    )
    return _with_axis(radii, means)


def _paraboloid(places: Array, heights: Array) -> tuple[Array, float]:
    """Return the slopes (2,) at the origin of the nearest paraboloid, and the factor of r^2."""
    design = np.column_stack([np.ones(len(places)), places, (places**2).sum(axis=1)])
    _, *slopes, square = np.linalg.lstsq(design, heights, rcond=None)[0]
    return np.array(slopes), float(square)


def _vertex(positions: Array, heights: Array, level: bool) -> float:
    """Return the position of the axis in a scan: its lowest or highest point, or its middle."""
    if level:
        return float(positions[0] + positions[-1]) / 2
    square, slope, _ = np.polyfit(positions, heights, 2)
    return float(-slope / (2 * square)) if square else 0.0


def _leveled_radius(radii: Array, heights: Array, level: bool, notes: list[str]) -> Array:
    """Return heights along a radius, without offset and slope at the axis if they are removed.

    The slope at the axis of a smooth face is zero. It is that of a fit with a straight line and
    even powers of the radius.
    """
    powers = [power for power in POWERS if power < len(radii)]
    reach = float(radii[-1]) or 1.0
    design = (radii[:, None] / reach) ** np.array(powers)
    fitted = np.linalg.lstsq(design, heights, rcond=None)[0]
    slope = float(fitted[1] / reach) if len(powers) > 2 else 0.0
    if level:
        notes.append(f"an offset of {fitted[0]:.3g} and a slope of {slope:.3g} were removed")
        return heights - fitted[0] - slope * radii
    misfit = np.abs(design @ fitted - heights).max()
    noticeable = SLOPE_KEPT * np.ptp(heights)
    if heights.min() < 0 and abs(slope) * reach > noticeable > misfit:
        notes.append(
            f"the slope of {slope:.3g} at the axis was kept, because it may be real; level = true "
            "removes it"
        )
    return heights


def _with_axis(radii: Array, heights: Array) -> tuple[Array, Array]:
    """Return radii and heights that begin at the axis, if they begin near it."""
    if len(radii) < 3 or not 0 < radii[0] <= 2 * (radii[1] - radii[0]):
        return radii, heights
    rise = (heights[1] - heights[0]) / (radii[1] ** 2 - radii[0] ** 2)
    return np.append(0.0, radii), np.append(heights[0] - rise * radii[0] ** 2, heights)
