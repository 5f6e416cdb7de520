"""Headings of columns: the quantity, the unit and the time in them.

Programs write `CPRESS`, `contact_pressure`, `solid.Tn` or `sigma_zz` for the pressure, and `U2`,
`disp_y` or `disp:1` for the displacement.
"""

import re
from collections.abc import Container
from typing import NamedTuple


class Name(NamedTuple):
    """What other programs call a column.

    Parameters
    ----------
    name : our name
    kind : of its unit
    pattern : of their names, in lower case with underscores for all marks
    signed : whether its sign may be the opposite of ours, as that of stresses is, and that of
        displacements along an axis that points out of the half-space
    """

    name: str
    kind: str
    pattern: str
    signed: bool = False


NAMES = (
    Name("time", "time", r"t"),
    Name("time", "time", r"((total|step|elapsed|sliding|test)_)?times?(_value)?"),
    Name("distance", "distance", r"(sliding|wear|total_sliding)_distance"),
    Name("cycles", "number", r"cycle|(n|no|num|number)_(of_)?cycles|cycle_(no|number)"),
    Name("radius", "length", r"r|rho|radii|radial_(position|distance|coordinate)"),
    Name("radius", "length", r"r_?coord\w*|points?_0|coord\w*_[0x1]|coor1"),
    Name("radius", "length", r"x|x_?(coord|loc|pos)\w*|position\w*|lateral\w*"),
    Name("radius", "length", r"arc_?length|(true_)?distance\w*|path(_distance)?"),
    Name("position", "length", r"s|length"),
    Name("pressure", "pressure", r"p|contact_pressure"),
    Name(
        "pressure",
        "pressure",
        r"cpress\w*|cont_?pres\w*|\w*contact_?press\w*|(\w+_)?tn|\w*normal_?contact_?(pressure"
        r"|stress)|\w*contact_?normal_?(pressure|stress|traction)|penalty_?pressure\w*"
        r"|pressure_\w+",
    ),
    Name("pressure", "pressure", r"(\w*_)?(s|sig|sigma|stress)_?(zz|yy|22|33|z|y)(_\w+)?", True),
    Name("displacement", "displacement", r"u|uz|u_z"),
    Name(
        "displacement",
        "displacement",
        r"((\w*_)?u_?[23yz]|(\w*_)?disp(l|lacements?)?_?[12yz]|(\w+_)?w|v|d_?[yz]"
        r"|[yz]_disp(l|lacement)?|directional_deformation)(_\w+)?",
        True,
    ),
    Name("profile", "displacement", r"f|worn_profile|wear"),
    Name("indentation", "displacement", r"d|depth|approach|(penetration|indentation)(_depth)?"),
    Name("normal_force", "force", r"fn|f_n|force|load|normal_load"),
    Name(
        "normal_force",
        "force",
        r"((\w*_)?rf_?[23yz]|(\w*_)?cfn_?[m23]?|(\w*_)?reaction(_force)?_?[yz]?)(_\w+)?",
        True,
    ),
    Name("normal_force", "force", r"f"),
    Name("contact_radius", "length", r"radius_of_contact"),
    Name("scar_diameter", "length", r"(wear_)?scar_(diameter|width)"),
    Name("worn_volume", "volume", r"wear_volume|volume_loss|lost_volume"),
    Name("lost_mass", "mass", r"mass_loss|weight_loss|wear_mass"),
    Name("height", "length", r"z|h|heights?|profile|elevation|topography|depths?|wear_?depth|f"),
    Name("height", "length", r"y"),
)
"""Names of quantities; for each of them, the first that matches a heading is used."""
PER_RING = ("worn_volume", "lost_mass")
"""Quantities that may be those of one ring, whose number is then at the end of the name."""
KINDS = {each.name: each.kind for each in NAMES}
"""Kinds of units of columns, by our names."""

UNIT = re.compile(r"^(?P<name>[^\[(/]+?)[_\s]*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|/\s*(?P<c>.+))$")
"""A heading with a unit in brackets, in parentheses or after a slash."""
BRACKETS = re.compile(r"\s*[\[(][^\[(]*[\])]$")
"""A unit at the end of a heading."""
UNITS = (
    *("um", "µm", "μm", "nm", "mm", "cm", "Pa", "kPa", "MPa", "GPa", "psi", "kN", "ms", "mg", "kg"),
    *("N/mm^2", "N/mm2", "N/m^2", "mm3", "mm^3"),
)
"""Units that programs write in capitals, too."""
SPELLINGS = {
    **dict.fromkeys(("micron", "microns", "micrometer", "micrometers", "micrometre"), "um"),
    **{unit.lower(): unit for unit in UNITS},
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
}
"""Units that a heading may end with, by their names in lower case."""
INDICES = {
    **dict.fromkeys(("s", "min", "h", "hours", "minutes", "days"), ("time",)),
    **dict.fromkeys(("m", "km"), ("length", "displacement", "distance")),
    **dict.fromkeys(("N", "mN", "uN"), ("force",)),
    "g": ("mass",),
    "mPa": ("pressure",),
}
"""Units that are also indices, with the kinds of the names that may end with them."""
LENGTH_UNIT = re.compile(r"length unit[:,]\s*(\S+)", re.IGNORECASE)
"""A comment of COMSOL with the unit of coordinates."""
WORD = re.compile(r"(?P<name>.+?)(?:[_\s]+in[_\s]+|[_\s]+)(?P<unit>[^_\s]+)")
"""A heading that ends with a word, which may be a unit: x_um, x um, x in um."""
TIME = re.compile(
    r"(?P<heading>.+?)\s*(?:@\s*|,\s*|\(\s*|\[\s*|\s)(?:t|time)\s*=\s*"
    r"(?P<time>\d*\.?\d+(?:E[-+]?\d+)?)"
    r"\s*(?P<unit>[^\s\])]*)[\])]?",
    re.IGNORECASE,
)
"""A heading of one time among others: p (MPa) @ t=1800, p(t=1800)."""
KNOWN = {*SPELLINGS, *INDICES, "", "-", "1", "%", "in", "kn", "mn", "n", "°c"}
"""Units that a row of their own may have, in lower case."""


class Heading(NamedTuple):
    """The name in a heading, in lower case with underscores, and the unit; empty if none."""

    name: str
    unit: str


def split_heading(heading: str) -> Heading:
    """Return the name in a heading, and the unit in any of its usual forms."""
    name, unit = heading.strip(), ""
    if matched := UNIT.match(name):
        name, unit = matched["name"], next(filter(None, matched.group("a", "b", "c")), "")
    elif matched := WORD.fullmatch(name):
        word = matched["unit"]
        of_names = INDICES.get(word)
        if (of_names is None and _spelt(word) in {*SPELLINGS.values(), "s"}) or (
            of_names
            and any(_matches(each, matched["name"]) for each in NAMES if each.kind in of_names)
        ):
            name, unit = matched["name"], word
    return Heading(re.sub(r"\s+", "_", name.strip().lower()), _spelt(unit.strip()))


def _matches(entry: Name, name: str) -> bool:
    """Return whether a name is one of other programs, or ours."""
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    return plain == entry.name or re.fullmatch(entry.pattern, plain) is not None


def name_of(heading: str, wanted: Container[str] = KINDS) -> tuple[int, Name] | None:
    """Return what a heading is called here, and its place in `NAMES`; None if it is not known.

    Parameters
    ----------
    heading : of another program
    wanted : our names of which it may be one
    """
    name, unit = split_heading(heading)
    # that of a ring
    base = re.sub(r"_\d+$", "", name)
    if name in wanted or (base in wanted and base in PER_RING):
        return -1, Name(name, KINDS.get(base, ""), name)
    for place, entry in enumerate(NAMES):
        # F [N] is a force
        of_unit = entry.kind in INDICES.get(unit, KINDS.values())
        if of_unit and entry.name in wanted and _matches(entry, name):
            return place, entry
    return None


def _spelt(unit: str) -> str:
    """Return a unit as pint knows it; mPa is left, which is not MPa."""
    key = unit.lower() if unit.istitle() or unit.isupper() else unit
    return SPELLINGS.get(key, unit)


def is_unit(cell: str) -> bool:
    """Return whether a cell in a row of its own is a unit, with or without brackets."""
    bracketed = re.fullmatch(r"[\[(](.+)[\])]", cell.strip())
    return bracketed is not None or cell.strip().lower() in KNOWN
