"""Recognise the columns of other programs by their headings, and give them our names.

Programs write `CPRESS`, `contact_pressure`, `solid.Tn` or `sigma_zz` for the pressure, and `U2`,
`disp_y` or `disp:1` for the displacement. Stresses, and displacements along an axis that points out
of the half-space, have the opposite sign of ours: their values show it.
"""

import re
from collections.abc import Container
from typing import NamedTuple

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError
from ..crosscheck import SYMBOLS
from ..tables.circles import on_circles
from ..tables.text import split_heading


class Kind(NamedTuple):
    """What other programs call a column.

    Parameters
    ----------
    name : our name
    pattern : of their names, in lower case with underscores for all marks
    signed : whether its sign may be the opposite of ours
    """

    name: str
    pattern: re.Pattern[str]
    signed: bool = False


# the first that matches a heading, and the first heading of each name, are used
KINDS = (
    Kind("time", re.compile(r"(total_|step_)?time(_value)?")),
    Kind("radius", re.compile(r"(radius|radii|rho|r_?coord\w*|points?_0|coord\w*_[0x1]|coor1)")),
    Kind("radius", re.compile(r"(x|x_?(coord|loc|pos)\w*|position|lateral)")),
    Kind("radius", re.compile(r"(arc_?length|(true_)?distance\w*|path(_distance)?)")),
    Kind(
        "pressure",
        re.compile(
            r"(cpress\w*|cont_?pres\w*|\w*contact_?press\w*|(\w+_)?tn|\w*normal_?contact_?(pressure"
            r"|stress)|\w*contact_?normal_?(pressure|stress|traction)|penalty_?pressure\w*"
            r"|pressure_\w+)"
        ),
    ),
    Kind(
        "pressure",
        re.compile(r"(\w*_)?(s|sig|sigma|stress)_?(zz|yy|22|33|z|y)(_\w+)?"),
        signed=True,
    ),
    Kind(
        "displacement",
        re.compile(
            r"((\w*_)?u_?[23yz]|(\w*_)?disp(l|lacements?)?_?[12yz]|(\w+_)?w|v|d_?[yz]"
            r"|[yz]_disp(l|lacement)?|directional_deformation)(_\w+)?"
        ),
        signed=True,
    ),
    Kind(
        "normal_force",
        re.compile(
            r"((\w*_)?rf_?[23yz]|(\w*_)?cfn_?[m23]?|(\w*_)?reaction(_force)?_?[yz]?)(_\w+)?"
        ),
        signed=True,
    ),
)


def our_name(heading: str) -> str:
    """Return our name of a heading that is ours, or a usual symbol; else the name in it."""
    name, _ = split_heading(heading)
    return SYMBOLS.get(name, name)


def kind_of(heading: str) -> Kind | None:
    """Return what a heading of another program is called here; None if it is not known."""
    name = re.sub(r"[^a-z0-9]+", "_", split_heading(heading)[0]).strip("_")
    return next((kind for kind in KINDS if kind.pattern.fullmatch(name)), None)


def recognised(
    frame: pd.DataFrame, wanted: Container[str]
) -> tuple[pd.DataFrame, dict[str, str], list[str]]:
    """Return a table with our names for columns of other programs, units in them, and remarks.

    Columns that have our names already are kept, and no other takes their place.

    Parameters
    ----------
    frame : a table of texts or numbers
    wanted : our names that a column may have

    Raises
    ------
    SceneError
        if two columns may be the same quantity
    """
    candidates = dict[str, list[tuple[int, object, Kind]]]()
    for heading in frame:
        kind = None if str(heading) in wanted else kind_of(str(heading))
        if kind and kind.name in wanted and kind.name not in frame:
            candidates.setdefault(kind.name, []).append((KINDS.index(kind), heading, kind))
    names, units, remarks = dict[object, str](), dict[str, str](), list[str]()
    signs = dict[str, float]()
    present = {*map(str, frame), *candidates}
    # along a path of forces there is time, and the displacement without a radius is the punch's
    over_time = "normal_force" in present and not present & {"pressure", "profile", "time"}
    meant = {"radius": "time"} if over_time else {}
    if over_time or "radius" not in present:
        meant["displacement"] = "indentation"
    for name, found in candidates.items():
        best = min(order for order, _, _ in found)
        headings = [(heading, kind) for order, heading, kind in found if order == best]
        if len(headings) > 1:
            # components that vanish are those across the plane
            headings = [each for each in headings if _numbers(frame, each[0]).any()] or headings
        if len(headings) > 1:
            both = " and ".join(repr(str(heading)) for heading, _ in headings)
            raise SceneError(
                f"{both} may both be {name}: choose one by --columns '{headings[0][0]}={name}'"
            )
        ((heading, kind),) = headings
        name = meant.get(name, name)
        names[heading], units[name] = name, split_heading(str(heading))[1]
        remark = f"{heading} is read as {name}"
        if kind.signed and np.nansum(_numbers(frame, heading)) < 0:
            signs[name] = -1.0
            remark += ", with the opposite sign, because it is negative"
        remarks.append(remark)
    frame = frame.rename(columns=names)
    for name, sign in signs.items():
        frame[name] = sign * _numbers(frame, name)
    return frame, {name: unit for name, unit in units.items() if unit}, remarks


def over_radii(frame: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Return a table of values on a grid, or on both sides of the axis, as means over circles.

    The remarks say how much values on one circle differ. Other tables are returned as they are.

    Parameters
    ----------
    frame : with the columns x and y, or with radii of either sign
    """
    names = {split_heading(str(heading))[0]: heading for heading in frame}
    if "radius" in frame:
        radii = _numbers(frame, "radius")
        if not np.nanmin(radii, initial=0.0) < 0 < np.nanmax(radii, initial=0.0):
            return frame, []
        return _on_circles(frame.drop(columns="radius"), radii, np.zeros(len(radii)))
    if not {"x", "y"} <= names.keys():
        return frame, []
    x, y = (_numbers(frame, names[each]) for each in ("x", "y"))
    if not np.ptp(y):
        return frame, []
    return _on_circles(frame.drop(columns=[names["x"], names["y"]]), x, y)


def _on_circles(frame: pd.DataFrame, x: Array, y: Array) -> tuple[pd.DataFrame, list[str]]:
    """Return a table of the means over circles of the columns of a table of values at points."""
    times = _numbers(frame, "time") if "time" in frame else np.zeros(len(frame))
    tables, spreads = list[pd.DataFrame](), dict[str, float]()
    for time in np.unique(times):
        rows, table = times == time, dict[str, Array | float]()
        for name in frame.columns.difference(["time"], sort=False):
            values = _numbers(frame, name)[rows]
            radii, means, spread = on_circles(x[rows], y[rows], values)
            table |= {"radius": radii, str(name): means}
            spreads[str(name)] = max(spreads.get(str(name), 0.0), spread)
        tables.append(pd.DataFrame({"time": time, **table} if "time" in frame else table))
    remarks = [
        f"{name}: means over circles around the axis, on which values differ by up to {spread:.3g}"
        for name, spread in spreads.items()
    ]
    return pd.concat(tables, ignore_index=True), remarks


def _numbers(frame: pd.DataFrame, heading: object) -> Array:
    return pd.to_numeric(frame[heading], errors="coerce").to_numpy(dtype=float)
