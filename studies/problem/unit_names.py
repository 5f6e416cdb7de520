"""Units of a scene: those of its numbers, those that people write, and those that they read best.

A scene states its units as ``SI``, or as those of length, force, pressure and time: ``mm, N, MPa,
s``, which must be consistent, a pressure being a force over the square of a length. Without, its
numbers have none. Any number may be a quantity instead, ``"20 mm"``: it is converted to them, to SI
by default. pint knows the units, and is loaded only where some are written that are not SI's own.
The unit of each key is declared beside its type (`Unit`), in the models of the scene's tables.
"""

import difflib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, get_args

import numpy as np
from pydantic import BaseModel

from ...meshes.errors import SceneError
from .fields import TomlTable, Unit

if TYPE_CHECKING:
    from pint import UnitRegistry

YEAR = 365.25 * 86400.0
# units that people read a kind of quantity in, with their sizes in SI units, ascending
SI: dict[str, dict[str, float]] = {
    "length": {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0},
    "force": {"µN": 1e-6, "mN": 1e-3, "N": 1.0, "kN": 1e3, "MN": 1e6},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    "time": {
        "µs": 1e-6,
        "ms": 1e-3,
        "s": 1.0,
        "min": 60.0,
        "h": 3600.0,
        "days": 86400.0,
        "years": YEAR,
    },
    "wear_rate": {
        "nm/year": 1e-9 / YEAR,
        "µm/year": 1e-6 / YEAR,
        "nm/h": 1e-9 / 3600,
        "µm/h": 1e-6 / 3600,
        "mm/h": 1e-3 / 3600,
        "mm/s": 1e-3,
        "m/s": 1.0,
    },
    "volume": {"µm³": 1e-18, "mm³": 1e-9, "cm³": 1e-6, "m³": 1.0},
    "wear_coefficient": {"mm³/(N m)": 1e-9},
}
SI["displacement"] = SI["length"]
BASE = ("m", "N", "Pa", "s")
# names of units of which there is one
SINGULAR = {"days": "day", "years": "year"}
# of numbers without units
NO_UNIT = "1"
# kind of a scene key without a unit
NUMBER = "number"


class Key(NamedTuple):
    """What a scene key may hold.

    Parameters
    ----------
    kind : of its unit; `number` if it has none
    tables : the models of the tables that it may hold
    """

    kind: str = NUMBER
    tables: tuple[type[BaseModel], ...] = ()


@lru_cache(maxsize=128)
def keys_in(declared: Key) -> dict[str, Key]:
    """Return the keys of the tables that a key may hold, as their models declare them.

    Raises
    ------
    TypeError
        if a unit is of no kind that `SI` has, or if one key has units of two kinds
    """
    keys = dict[str, Key]()
    for table in declared.tables:
        for name, info in table.model_fields.items():
            annotations = [*_parts(info.annotation), *info.metadata]
            kinds: set[str] = {part.kind for part in annotations if isinstance(part, Unit)}
            if name == "values":
                kinds = kinds or {declared.kind}
            tables = tuple(part for part in annotations if isinstance(part, type))
            key = Key(next(iter(kinds), NUMBER), tables)
            if len(kinds) > 1 or keys.setdefault(info.alias or name, key).kind != key.kind:
                raise TypeError(f"the key {name} of {table.__name__} has units of two kinds")
            if key.kind not in (NUMBER, *SI):
                raise TypeError(f"no unit is of the kind {key.kind!r}: give one of {', '.join(SI)}")
    return keys


def _parts(annotation: object) -> Iterator[Unit | type[BaseModel]]:
    """Yield the units and the models of tables in a type, at any depth."""
    if isinstance(annotation, Unit) or (
        isinstance(annotation, type) and issubclass(annotation, BaseModel)
    ):
        yield annotation
    for part in get_args(annotation):
        yield from _parts(part)


def kind_of(key: str, scene: type[BaseModel]) -> str:
    """Return the kind of unit that a key of a scene has, such as ``punch.radius``."""
    declared = Key(tables=(scene,))
    # of a list of tables each has a number
    for name in filter(lambda part: not part.isdigit(), key.split(".")):
        declared = keys_in(declared).get(name, Key())
    return declared.kind


@dataclass(frozen=True)
class UnitNames:
    """What the numbers of a scene are in.

    Parameters
    ----------
    base : units of length, force, pressure and time; None of numbers without units
    """

    base: tuple[str, ...] | None = None

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, stated: str) -> "UnitNames":
        """Return the names that a scene's `units` stand for.

        Raises
        ------
        SceneError
            if they are no units, or not consistent
        """
        if stated.strip() in ("", NO_UNIT):
            return cls()
        parts = tuple(part.strip() for part in stated.split(","))
        if parts == BASE or re.match(r"SI\b", stated.strip()):
            return cls(BASE)
        if len(parts) != len(BASE):
            raise SceneError(
                f"units = {stated!r}: give 'SI', or units of length, force, pressure and time that "
                "are consistent, such as 'mm, N, MPa, s', or leave it out for numbers without units"
            )
        names = cls(parts)
        length, force, pressure, _ = map(names.size, ("length", "force", "pressure", "time"))
        ratio = force / length**2 / pressure
        if abs(ratio - 1) > 1e-9:
            raise SceneError(
                f"units = {stated!r} are not consistent: {parts[1]}/{parts[0]}^2 is {ratio:.6g} "
                f"{parts[2]}; 'SI', 'mm, N, MPa, s' and 'um, uN, MPa, s' are"
            )
        return names

    def size(self, kind: str) -> float:
        """Return the unit that a kind of quantity is stored in, in SI units."""
        if self.base in (None, BASE):
            return 1.0
        if (size := _size_in_si(self.name(kind), kind)) is None:
            unit = self.name(kind)
            raise SceneError(
                f"units: {unit!r} is no unit of {kind.replace('_', ' ')}: "
                f"{nearest_unit(unit, kind)}give 'SI', or units of length, force, pressure and "
                "time that are consistent, such as 'mm, N, MPa, s'"
            )
        return size

    def name(self, kind: str) -> str:
        """Return the unit that a kind of quantity is stored in; 1 if it has none."""
        if self.base is None or kind in ("slope", "share", NUMBER):
            return NO_UNIT
        length, force, pressure, time = self.base
        names = {"length": length, "displacement": length, "force": force, "pressure": pressure}
        names |= {"time": time, "wear_rate": f"{length}/{time}", "volume": f"{length}^3"}
        return (names | {"wear_coefficient": f"1/{pressure}"})[kind]

    def readable(self, size: float, kind: str) -> tuple[float, str]:
        """Return a unit that numbers of this size are best read in.

        How much of the stored unit it is, and its name. Numbers of a scene in SI units have
        prefixes. Those of a scene in other units stay in these.
        """
        choices = self._choices(kind)
        if not choices or not np.isfinite(size) or size == 0:
            name = self.name(kind)
            return 1.0, "" if name == NO_UNIT else name.replace("^3", "³")
        stored = self.size(kind)
        name, unit = next(iter(choices.items()))
        # so much smaller than the smallest that a power of ten is plainer
        if self.base == BASE and abs(size) * stored < 1e-3 * unit and len(choices) > 1:
            return 1.0, self.name(kind)
        for larger, its_size in choices.items():
            # 0.39 mm³, not 3.9e8 µm³
            if abs(size) * stored >= 0.9995 * min(its_size, 1e6 * unit):
                name, unit = larger, its_size
        return unit / stored, name

    def _choices(self, kind: str) -> dict[str, float]:
        """Return the units that a kind of quantity may be read in, with their sizes in SI units."""
        if self.base in (None, BASE) or kind == "wear_coefficient":
            return SI.get(kind, {}) if self.base else {}
        length, _, _, time = self.base
        if kind == "time" and time == "s":
            return {name: size for name, size in SI["time"].items() if size >= 1}
        if kind == "wear_rate" and time == "s":
            metres = self.size("length")
            return {f"{length}/h": metres / 3600, f"{length}/s": metres}
        return {}

    def write(self, value: float, kind: str, digits: int = 4) -> str:
        """Return a value with its unit, for people."""
        if not np.isfinite(value):
            return "infinite" if np.isinf(value) else "not computed"
        unit, name = self.readable(value, kind)
        # 190, not 1.9e+02
        number = float(f"{value / unit:.{digits}g}")
        if kind == "time":
            number, name = self._rounder_time(value, number, name, digits)
        return f"{number:g} {name}".rstrip()

    def _rounder_time(
        self, value: float, number: float, name: str, digits: int
    ) -> tuple[float, str]:
        """Return a time in the next smaller unit if it has fewer digits there: 30 h, not 1.25 days.

        So times of a scene that speaks of hours are in hours.
        """
        choices = list(self._choices("time").items())
        at = [choice for choice, _ in choices].index(name) if name in dict(choices) else 0
        if at and value:
            smaller, its_size = choices[at - 1]
            in_smaller = float(f"{value * self.size('time') / its_size:.{digits}g}")
            exact = abs(in_smaller * its_size / self.size("time") / value - 1) < 1e-9
            if exact and in_smaller <= 1000 and _digits(in_smaller) < _digits(number):
                return in_smaller, smaller
        return number, SINGULAR.get(name, name) if number == 1 else name


def without_quantities(table: Mapping[str, object], scene: type[BaseModel]) -> TomlTable:
    """Return a scene's table with a number in place of each quantity, in the scene's units.

    Parameters
    ----------
    table : of the scene, nested
    scene : the model whose annotations declare the unit of each key

    Raises
    ------
    SceneError
        if the units are none, or not consistent, or something is no quantity of its key's kind
    """
    stated, written = table.get("units", "SI"), list[str]()
    names = UnitNames.of(stated) if isinstance(stated, str) else UnitNames()

    def convert_all(values: Mapping[str, object], path: str, declared: Key) -> TomlTable:
        keys = keys_in(declared)
        # one of a list of tables, by its number, is declared as the list is
        return {
            name: convert(of, path + name, keys.get(name, declared if name.isdigit() else Key()))
            for name, of in values.items()
        }

    def convert(value: object, path: str, declared: Key) -> object:
        if isinstance(value, Mapping):
            return convert_all(value, f"{path}.", declared)
        # numbers and arrays of numpy and pandas
        if callable(as_list := getattr(value, "tolist", None)):
            value = as_list()
        if isinstance(value, list | tuple | range):
            return [convert(of, path, declared) for of in value]
        # 'running-in' is a text
        if isinstance(value, str) and declared.kind in SI and re.match(r"[-+.\s]*\d", value):
            written.append(path)
            return _number(value, path, declared.kind, names)
        return value

    converted = convert_all(table, "", Key(tables=(scene,)))
    return {"units": "SI"} | converted if written else converted


def _number(quantity: str, key: str, kind: str, names: UnitNames) -> float:
    """Return a quantity of a kind in the units of a scene."""
    number, unit = _split(quantity)
    if names.base is None and unit:
        raise SceneError(
            f"{key} = {quantity!r} has a unit, and the scene says that its numbers have none: give "
            "units = 'SI', or leave units out"
        )
    if not unit:
        raise SceneError(f"{key} = {quantity!r} has no unit: leave out the quotes, or add a unit")
    # pint would take 1,5 for fifteen
    if "," in number:
        point = number.replace(",", ".")
        raise SceneError(f"{key} = {quantity!r}: give '{point} {unit}', with a decimal point")
    try:
        value = _registry().Quantity(quantity).to(UnitNames(BASE).name(kind)).magnitude
    # text that is no expression fails in many ways
    except Exception:
        raise SceneError(
            f"{key} = {quantity!r} is no {kind.replace('_', ' ')}: {nearest_unit(unit, kind)}give "
            f"a number and a unit of {kind.replace('_', ' ')}, such as "
            f"{', '.join(list(SI[kind])[-3:])}, or a number alone"
        ) from None
    return float(value) / names.size(kind)


def _split(quantity: str) -> tuple[str, str]:
    """Return the number that a quantity begins with, and what comes after it."""
    number = re.match(r"[-+.,\s\d]*(?:[eE][-+]?\d+)?", quantity)
    end = number.end() if number else 0
    return quantity[:end].strip(), quantity[end:].strip()


def nearest_unit(unit: str, kind: str) -> str:
    """Return the question whether a like unit of a kind is meant; empty if none is like it."""
    known = {name.lower(): name for name in SI[kind]}
    near = known.get(unit.lower())
    if near is None and _size_in_si(unit.lower(), kind) is not None:
        near = unit.lower()
    if near is None:
        near = next(iter(difflib.get_close_matches(unit, SI[kind], 1)), None)
    return f"did you mean '{near}'? Else " if near else ""


def _digits(number: float) -> int:
    """Return how many significant digits a number has."""
    return len(f"{number:.15g}".replace(".", "").strip("0"))


def size_of_unit(unit: str, kind: str, place: str) -> float:
    """Return how much of the SI unit of a kind a unit is.

    Raises
    ------
    SceneError
        if it is no unit of that kind, naming the place where it stands
    """
    if (size := _size_in_si(unit, kind)) is None:
        raise SceneError(
            f"{place}: {unit!r} is no unit of {kind.replace('_', ' ')}: "
            f"{nearest_unit(unit, kind)}give one such as {', '.join(list(SI[kind])[-3:])}"
        )
    return size


@lru_cache(maxsize=64)
def _size_in_si(unit: str, kind: str) -> float | None:
    """Return how much of the SI unit of a kind a unit is; None if it is none of that kind."""
    try:
        return float(_registry().Quantity(1.0, unit).to(UnitNames(BASE).name(kind)).magnitude)
    # text that is no unit fails in many ways
    except Exception:
        return None


@lru_cache(maxsize=1)
def _registry() -> "UnitRegistry":
    from pint import UnitRegistry

    # as they are written in papers: mm3 and mm3/Nm
    return UnitRegistry(
        preprocessors=[
            lambda text: re.sub(r"(?<![\d.])([a-zµμ])([23])\b", r"\1^\2", text),
            lambda text: re.sub(r"\bNm\b", "(N m)", text),
        ]
    )
