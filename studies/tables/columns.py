"""Choose the columns of a table that are known, and give them our names, signs and radii."""

from collections.abc import Container, Mapping
from dataclasses import replace

from ...meshes import SceneError
from .frame import Frame, on_circles
from .headings import name_of, split_heading


def known_columns(
    frame: Frame, wanted: Container[str], columns: Mapping[str, str]
) -> tuple[Frame, list[str], list[str]]:
    """Return the columns of a table that are known, by our names, over radii from 0.

    Parameters
    ----------
    frame : the table
    wanted : our names that a column may have
    columns : our names by those of the user

    Returns
    -------
    frame, remarks, others
        the table; remarks on what is only guessed; and headings of the columns that are not known

    Raises
    ------
    SceneError
        if two columns may be the same quantity, or if a cell is no number
    """
    names = {heading: ours for theirs, ours in columns.items() for heading in frame.find(theirs)}
    grid = {} if "radius" in names.values() else _grid(frame)
    names |= grid
    taken = {*names.values(), *(["radius"] if grid else [])}
    found = {
        heading: pair
        for heading in frame.cells
        if heading not in names and (pair := name_of(heading, wanted)) and pair[1].name not in taken
    }
    quantities = dict.fromkeys(entry.name for _, entry in found.values())
    present = taken | quantities.keys()
    # along a path of forces there is time, and the displacement without a radius is the punch's
    over_time = "normal_force" in present and not present & {"pressure", "profile", "time"}
    opposite, remarks = set[str](), list[str]()
    for name in quantities:
        heading = _best(
            frame, name, {key: at for key, (at, each) in found.items() if each.name == name}
        )
        signed = found[heading][1].signed
        if over_time and split_heading(heading).name == "x":
            name = "time"
        elif signed and name == "displacement" and (over_time or "radius" not in present):
            name = "indentation"
        names[heading] = name
        remark = f"{heading} is read as {name}"
        if signed and frame.values[heading].sum() < 0:
            opposite.add(name)
            remark += ", with the opposite sign, because it is negative"
        if split_heading(heading).name != name:
            remarks.append(remark)
        if heading in frame.clocks:
            remarks.append(f"{heading}: dates are seconds since the first, clocks since 0:00:00")
    ours = {name for name in names.values() if (pair := name_of(name, wanted)) and pair[0] < 0}
    used = {heading: name for heading, name in names.items() if name in ours} | grid
    if len({*used.values()}) < len(used):
        raise SceneError(f"{frame.name} has a column twice among {', '.join(used)}: name one only")
    frame.refuse_faults(used)
    others = [heading for heading in frame.cells if heading not in used]
    units = {used[heading]: unit for heading, unit in frame.units.items() if heading in used}
    values, cells = (table[[*used]].rename(columns=used) for table in (frame.values, frame.cells))
    values = values.assign(**{name: -values[name] for name in opposite})
    if grid:
        units["radius"] = units.pop("x", "")
        if units.pop("y", "") != units["radius"]:
            raise SceneError(f"{frame.name}: x and y have different units: give both in one")
    elif "radius" in values and values["radius"].min() < 0 < values["radius"].max():
        values = values.rename(columns={"radius": "x"}).assign(y=0.0)
    if "y" in values:
        values, spreads = on_circles(values)
        cells = values
        remarks += [
            f"{name}: means over circles around the axis, on which values differ by up to "
            f"{spread:.3g}"
            for name, spread in spreads.items()
        ]
    return replace(frame, cells=cells, values=values, units=units), remarks, others


def _grid(frame: Frame) -> dict[str, str]:
    """Return x and y by the headings of places on a grid, else none."""
    places = {split_heading(heading).name: heading for heading in frame.cells}
    on_grid = {"x", "y"} <= places.keys() and not {"r", "radius"} & places.keys()
    if on_grid and frame.values[places["y"]].nunique() > 1:
        return {places["x"]: "x", places["y"]: "y"}
    return {}


def _best(frame: Frame, name: str, places: Mapping[str, int]) -> str:
    """Return the heading of a quantity.

    Parameters
    ----------
    frame : the table
    name : of the quantity
    places : places in the list of names of all headings that it may have

    Raises
    ------
    SceneError
        if two columns may be that quantity
    """
    best = [heading for heading, place in places.items() if place == min(places.values())]
    if len(best) > 1:
        # components that vanish are those across the plane
        best = [heading for heading in best if frame.values[heading].any()] or best
    if len(best) > 1:
        raise SceneError(
            f"{frame.name}: {' and '.join(map(repr, best))} may both be {name}: choose one, and "
            f"leave out the other; or --columns '{best[0]}={name}'; if each is of one time, give a "
            "table with a row for each time and radius"
        )
    return best[0]
