"""Read the profile of a punch from a scan: heights along a line, or on a map.

A scan has two columns, positions and heights, or three, x, y and heights. A line may run along a
radius or over a whole diameter. Values that are no numbers are left out and counted. What is done
to a scan, and what is only guessed, is in its notes.
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError
from .frame import ROUNDOFF, Frame, on_circles
from .headings import name_of, split_heading

UNIT_LINE = re.compile(
    r"^.*\bunits?\b.*[:=,;\t ]\W*([nuµμmc]?m|micro\w+|in|inch)\b.*$", re.I | re.M
)
"""A line above the numbers that states a unit of length."""
SLOPE_KEPT = 0.05
"""A slope at the axis is mentioned if it makes this part of all height differences."""
POWERS = (2, 4, 6)
"""Powers of the radius, besides an offset and slopes, in a fit of a scan."""


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
    elsewhere = UNIT_LINE.search(frame.above)
    if elsewhere and not any(units):
        raise SceneError(
            f"{path} has a unit outside of its headings, {elsewhere[0].strip()!r}: give one in "
            "each heading, as in x [mm], z [um]"
        )
    frame.refuse_faults(dict(zip(columns, columns, strict=True)))
    rows, notes = frame.values[columns], list[str]()
    if "depth" in columns[-1].lower():
        notes.append(
            f"{columns[-1]} is read as the depth of missing material, not as a height below 0"
        )
    known = rows[np.isfinite(rows).all(axis=1)]
    if len(known) < len(rows):
        notes.append(f"{len(rows) - len(known)} of {len(rows)} values left out: no numbers")
    if len(known) < 2:
        raise SceneError(
            f"{path} has {len(known)} rows of numbers: give at least two, position and height"
        )
    constant = [column for column in columns[:-1] if known[column].nunique() == 1]
    if len(columns) == 3 and len(constant) == 1:
        value = known.pop(constant[0]).iloc[0]
        notes.append(f"a line, because {constant[0]} is {value:g} everywhere")
    places, heights = known.to_numpy()[:, :-1], known.to_numpy()[:, -1]
    is_line = places.shape[1] == 1
    if is_line and 2 * len(np.unique(places)) <= len(places):
        raise SceneError(f"{path} has each position twice or more: give each curve in a file")
    if center:
        middle = (places.max(axis=0) + places.min(axis=0)) / 2
        _, slopes, square, _ = _fit(places, heights, POWERS[:1])
        if square and not level:
            middle = -slopes / (2 * square)
        places = places - middle
        notes.append(f"the axis is at the position {_listed(middle, 6)} of the scan")
    # a position at the axis that is not 0 by roundoff
    places = np.where(np.abs(places) < ROUNDOFF * np.ptp(places, axis=0), 0.0, places)
    if is_line and places.max() <= 0:
        places = -places
    offset, slopes, _, misfit = _fit(places, heights, POWERS)
    noticeable = SLOPE_KEPT * np.ptp(heights)
    if level:
        heights = heights - offset - places @ slopes
        notes.append(f"an offset of {offset:.3g} and a slope of {_listed(slopes, 3)} were removed")
    elif (
        is_line
        and places.min() >= 0 > heights.min()
        and abs(slopes[0]) * places.max() > noticeable > misfit
    ):
        notes.append(
            f"the slope of {slopes[0]:.3g} at the axis was kept, because it may be real; level = "
            "true removes it"
        )
    if is_line:
        radii, heights = _folded(places[:, 0], heights, notes)
    else:
        means, spreads = on_circles(
            pd.DataFrame({"x": places[:, 0], "y": places[:, 1], "z": heights})
        )
        radii, heights = means[["radius", "z"]].to_numpy().T
        notes.append(
            f"a map: means over {len(radii)} circles around the axis, on which heights differ by "
            f"up to {spreads['z']:.3g}"
        )
        radii, heights = _with_axis(radii, heights)
    if level or heights.min() < 0:
        heights = heights - heights.min()
    return Scan(radii, heights, (units[0], units[-1]), tuple(notes))


def _listed(values: Array, digits: int) -> str:
    return ", ".join(f"{value:.{digits}g}" for value in values)


def _columns(frame: Frame) -> list[str]:
    """Return the headings of the columns of positions, one or two, and of heights."""
    headings = [heading for heading in frame.cells if frame.cells[heading].ne("").any()]
    names = [split_heading(heading).name for heading in headings]
    positions = _known(headings, ("radius", "position"))
    heights = _known(headings, ("height",))
    if {"x", "y"} <= {*names} and heights != [headings[names.index("y")]]:
        positions = [headings[names.index("x")], headings[names.index("y")]]
    chosen = [*positions, *heights]
    # else columns are in their usual order
    in_order = len(headings) == 3 and (names[0].isdigit() or names[:2] == ["x", "y"])
    if (len(headings) == 2 or in_order) and {*chosen} != {*headings}:
        return headings
    if len(heights) == 1 and len(positions) in (1, 2 * ("x" in names and "y" in names)):
        return chosen
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


def _fit(
    places: Array, heights: Array, powers: tuple[int, ...]
) -> tuple[float, Array, float, float]:
    """Fit a tilted face: an offset, slopes, and even powers of the distance from the axis.

    Only places whose mirror images are in the scan are used, if they are most of it.

    Parameters
    ----------
    places : (n, 1 or 2) positions from the axis
    heights : (n,) heights
    powers : of the distance; those that the number of places determines are used

    Returns
    -------
    offset, slopes (1 or 2,) at the axis, factor of the square, and the greatest misfit
    """
    radii = np.linalg.norm(places, axis=1)
    mirrored = radii <= np.minimum(places.max(axis=0), -places.min(axis=0)).min() * (1 + ROUNDOFF)
    used = mirrored if 2 * mirrored.sum() > len(radii) else radii >= 0
    reach = float(radii.max()) or 1.0
    columns = [(radii / reach) ** power for power in powers if power < len(radii)]
    design = np.column_stack([np.ones(len(radii)), places / reach, *columns])
    factors = np.linalg.lstsq(design[used], heights[used], rcond=None)[0]
    count = 1 + places.shape[1]
    square = factors[count] / reach**2 if columns else 0.0
    misfit = np.abs(design @ factors - heights).max()
    return float(factors[0]), factors[1:count] / reach, float(square), float(misfit)


def _folded(positions: Array, heights: Array, notes: list[str]) -> tuple[Array, Array]:
    """Return radii and heights of a line; over a diameter, the means of its halves."""
    line = pd.Series(heights, positions).sort_index(kind="stable")
    if positions.min() >= 0:
        return line.index.to_numpy(), line.to_numpy()
    grid = np.unique(np.round(np.abs(positions), 12))
    sides = line[line.index >= 0], line[line.index <= 0].rename(index=np.negative)[::-1]
    halves = pd.DataFrame(
        [np.interp(grid, side.index, side, right=np.nan) for side in sides], columns=grid
    )
    apart = halves.diff().abs().max(axis=None)
    notes.append(f"a scan over the diameter: its halves differ by up to {apart:.3g}")
    return _with_axis(grid, halves.mean().to_numpy())


def _with_axis(radii: Array, heights: Array) -> tuple[Array, Array]:
    """Return radii and heights that begin at the axis, if they begin near it."""
    if len(radii) < 3 or not 0 < radii[0] <= 2 * (radii[1] - radii[0]):
        return radii, heights
    rise = (heights[1] - heights[0]) / (radii[1] ** 2 - radii[0] ** 2)
    return np.append(0.0, radii), np.append(heights[0] - rise * radii[0] ** 2, heights)
