"""Handle the units of a scene: convert numbers with units, and choose readable units for output.

A scene states its units as ``SI``, or as units of length, force, pressure and time: ``mm, N, MPa,
s``. These must be consistent: a pressure is a force over the square of a length. Without this
statement, its numbers have no units. Any number may also be written with a unit, ``"20 mm"``; it is
converted to the units of the scene, by default to SI. The package pint does the conversion and is
loaded only when it is needed. The unit of each key is declared with its type (`Unit`), in the
models of the scene's tables.

If a scene gives no sliding speed, its times are sliding distances: they have units of length, and
wear rates are heights per length.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import lru_cache
from operator import eq
from typing import TYPE_CHECKING, NamedTuple, get_args

import numpy as np
from pydantic import BaseModel

from ....meshes.errors import SceneError
from .fields import TomlTable, Unit
from .suggestions import nearest
from .written import TOO_DEEP

if TYPE_CHECKING:
    from pint import UnitRegistry

YEAR = 365.25 * 86400.0
# readable units for each kind of quantity, with their sizes in SI units, ascending
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
    "speed": {"µm/s": 1e-6, "mm/s": 1e-3, "m/s": 1.0},
    "distance": {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0, "km": 1e3},
    "wear_per_distance": {
        "nm/km": 1e-12,
        "µm/km": 1e-9,
        "mm/km": 1e-6,
        "mm/m": 1e-3,
        "m/m": 1.0,
    },
    "volume": {"µm³": 1e-18, "mm³": 1e-9, "cm³": 1e-6, "m³": 1.0},
    "wear_coefficient": {"mm³/(N m)": 1e-9},
    "mass": {"µg": 1e-9, "mg": 1e-6, "g": 1e-3, "kg": 1.0},
    "density": {"kg/m³": 1.0, "g/cm³": 1e3},
}
SI["displacement"] = SI["length"]
# kinds of quantities instead of others, if the times of a scene are sliding distances
OF_DISTANCES = {"time": "distance", "wear_rate": "wear_per_distance"}
# multiple of a unit from which on numbers are written in it: 36 h rather than 1.5 days
WRITTEN_FROM = {"days": 2.0}
# ratio of two numbers above which they are not written in the unit of the smaller one
FAR_APART = 1e4
BASE = ("m", "N", "Pa", "s")
# names of units for the number 1
SINGULAR = {"days": "day", "years": "year"}
# least part of letters in common, twice over both lengths, of a unit that is suggested
LEAST_LIKENESS = 0.5
# name of the unit of numbers without units
NO_UNIT = "1"
# kind of unit of scene keys without a unit
NUMBER = "number"


class Key(NamedTuple):
    """The declaration of a scene key.

    Parameters
    ----------
    kind : str
        Kind of its unit; `NUMBER` if it has none.
    tables : tuple of types
        Models of the tables that may be its value.
    """

    kind: str = NUMBER
    tables: tuple[type[BaseModel], ...] = ()


@lru_cache(maxsize=128)
def keys_in(declared: Key) -> dict[str, Key]:
    """Return the declarations of the keys in the tables that may be the value of a key.

    Raises
    ------
    TypeError
        if the kind of a unit is not in `SI`, or if one key has units of two kinds
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
    """Yield the units and the models of tables within a type, at any depth."""
    if isinstance(annotation, Unit) or (
        isinstance(annotation, type) and issubclass(annotation, BaseModel)
    ):
        yield annotation
    for part in get_args(annotation):
        yield from _parts(part)


def kind_of(key: str, scene: type[BaseModel]) -> str:
    """Return the kind of unit of a scene key, such as ``punch.radius``."""
    declared = Key(tables=(scene,))
    # skip the indices of tables in lists
    for name in filter(lambda part: not part.isdigit(), key.split(".")):
        declared = keys_in(declared).get(name, Key())
    return declared.kind


@dataclass(frozen=True)
class UnitNames:
    """The units of the numbers of a scene.

    Parameters
    ----------
    base : tuple of str, optional
        Names of the units of length, force, pressure and time; None for numbers without units.
    distances : bool
        Whether times are sliding distances, because the scene gives no sliding speed.
    """

    base: tuple[str, ...] | None = None
    distances: bool = False

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, stated: str, distances: bool = False) -> "UnitNames":
        """Return the units that the `units` of a scene state.

        Raises
        ------
        SceneError
            if they are not units, or not consistent
        """
        if stated.strip() in ("", NO_UNIT):
            return cls(distances=distances)
        parts = tuple(part.strip() for part in stated.split(","))
        if parts == BASE or re.match(r"SI\b", stated.strip()):
            return cls(BASE, distances)
        if len(parts) != len(BASE):
            raise SceneError(
                f"units = {stated!r}: give 'SI', or units of length, force, pressure and time that "
                "are consistent, such as 'mm, N, MPa, s', or leave it out for numbers without units"
            )
        names = cls(parts, distances)
        length, force, pressure, _ = map(cls(parts).size, ("length", "force", "pressure", "time"))
        ratio = force / length**2 / pressure
        if abs(ratio - 1) > 1e-9:
            raise SceneError(
                f"units = {stated!r} are not consistent: {parts[1]}/{parts[0]}^2 is {ratio:.6g} "
                f"{parts[2]}; 'SI', 'mm, N, MPa, s' and 'um, uN, MPa, s' are"
            )
        return names

    def size(self, kind: str) -> float:
        """Return the size of the scene's unit for a kind of quantity, in SI units.

        Raises
        ------
        SceneError
            if the scene's name of the unit is not a unit of that kind
        """
        if self.base in (None, BASE):
            return 1.0
        kind = self._meant(kind)
        if (size := _size_in_si(self.name(kind), kind)) is None:
            unit = self.name(kind)
            raise SceneError(
                f"units: {unit!r} is not a unit of {kind.replace('_', ' ')}: "
                f"{nearest_unit(unit, kind)}give 'SI', or units of length, force, pressure and "
                "time that are consistent, such as 'mm, N, MPa, s'"
            )
        return size

    def name(self, kind: str) -> str:
        """Return the name of the scene's unit for a kind of quantity; "1" if it has none."""
        if self.base is None or kind in ("slope", "share", NUMBER):
            return NO_UNIT
        length, force, pressure, time = self.base
        names = {"length": length, "displacement": length, "force": force, "pressure": pressure}
        names |= {"time": time, "volume": f"{length}^3", "wear_coefficient": f"1/{pressure}"}
        names |= dict.fromkeys(("wear_rate", "speed"), f"{length}/{time}")
        names |= {"distance": length, "wear_per_distance": f"{length}/{length}"}
        names |= {"mass": f"{force}*{time}^2/{length}"}
        return (names | {"density": f"{names['mass']}/{length}^3"})[self._meant(kind)]

    def _meant(self, kind: str) -> str:
        """Return the kind of a quantity: that of a distance for a time that is a distance."""
        return OF_DISTANCES.get(kind, kind) if self.distances else kind

    def readings(self, kind: str) -> dict[str, "UnitNames"]:
        """Return the kinds of units in which a quantity can be given, with the units of a scene.

        A sliding distance can also be given as a time, at the sliding speed 1.
        """
        if self._meant(kind) == kind:
            return {kind: self}
        return {self._meant(kind): self, kind: UnitNames(self.base)}

    def size_of(self, unit: str, kind: str, place: str) -> float:
        """Return the size of a unit in the scene's unit of a kind of quantity.

        Raises
        ------
        SceneError
            if it is not a unit of that kind; the message names `place`, where the unit was found
        """
        for given_kind, names in self.readings(kind).items():
            if (size := _size_in_si(unit, given_kind)) is not None:
                return size / names.size(given_kind)
        kind = self._meant(kind)
        raise SceneError(
            f"{place}: {unit!r} is no unit of {kind.replace('_', ' ')}: "
            f"{nearest_unit(unit, kind)}give one such as {', '.join(list(SI[kind])[-3:])}"
        )

    def readable(self, size: float, kind: str) -> tuple[float, str]:
        """Return a readable unit for numbers of this size: its size in the scene's unit, its name.

        If the scene is in SI units, the unit may have a prefix. Other units are kept, except some
        of time and wear rate.
        """
        kind = self._meant(kind)
        choices = self._choices(kind)
        if not choices or not np.isfinite(size) or size == 0:
            name = self.name(kind)
            return 1.0, "" if name == NO_UNIT else name.replace("^3", "³")
        stored = self.size(kind)
        name, unit = next(iter(choices.items()))
        # far below the smallest unit, a power of ten of the SI unit is easier to read
        if self.base == BASE and abs(size) * stored < 1e-3 * unit and len(choices) > 1:
            return 1.0, self.name(kind)
        for larger, larger_size in choices.items():
            # 0.39 mm³, not 3.9e8 µm³
            least = min(WRITTEN_FROM.get(larger, 1.0) * larger_size, 1e6 * unit)
            if abs(size) * stored >= 0.9995 * least:
                name, unit = larger, larger_size
        return unit / stored, name

    def _choices(self, kind: str) -> dict[str, float]:
        """Return the readable units for a kind of quantity, with their sizes in SI units."""
        if self.base in (None, BASE) or kind == "wear_coefficient":
            return SI.get(kind, {}) if self.base else {}
        length, _, _, time = self.base
        if kind == "time" and time == "s":
            return {name: size for name, size in SI["time"].items() if size >= 1}
        if kind == "wear_rate" and time == "s":
            metres = self.size("length")
            return {f"{length}/h": metres / 3600, f"{length}/s": metres}
        if kind == "distance":
            metres = self.size("length")
            longer = {name: size for name, size in SI["distance"].items() if size > metres}
            return {length: metres} | longer
        if kind == "wear_per_distance":
            metres = self.size("length")
            per = {"km": metres / 1e3, "m": metres, length: 1.0}
            return {f"{length}/{name}": size for name, size in per.items()}
        return {}

    def readable_together(self, sizes: Iterable[float], kind: str) -> tuple[float, str]:
        """Return one readable unit for several numbers: its size in the scene's unit, its name.

        It is that of the smallest of them, or that of their mean magnitude if they are far apart.
        """
        magnitudes = np.abs([size for size in sizes if size and np.isfinite(size)])
        if not len(magnitudes):
            return self.readable(0.0, kind)
        unit, name = self.readable(float(magnitudes.min()), kind)
        if magnitudes.max() <= FAR_APART * unit:
            return unit, name
        mean_magnitude = float(np.sqrt(magnitudes.min()) * np.sqrt(magnitudes.max()))
        return self.readable(mean_magnitude, kind)

    def unit_of_times(self, times: Sequence[float]) -> tuple[float, str]:
        """Return a readable unit for times: its size in the scene's unit, and its name.

        It is that of the last one if this has up to three digits in it; otherwise the largest unit
        in which all of them have: 100 h, not 4.167 days; 2 h and 200 h, not 0.0833 and 8.33 days.
        """

        def are_short(unit: float, shown: Sequence[float]) -> bool:
            numbers = np.array(shown) / unit
            rounded = [float(f"{number:.3g}") for number in numbers]
            return bool((numbers <= 1000).all() and np.allclose(numbers, rounded, 1e-9, 0.0))

        last, choices = self.readable(times[-1], "time"), self._choices(self._meant("time"))
        if are_short(last[0], times[-1:]):
            return last
        units = [(size / self.size("time"), name) for name, size in choices.items()]
        return next((unit for unit in reversed(units) if are_short(unit[0], times)), last)

    def write_together(self, values: Sequence[float], kind: str) -> list[str]:
        """Return values of one kind as texts, all in one readable unit."""
        if len(values) == 1:
            return [self.write(values[0], kind)]
        readable = self.readable_together(values, kind)
        return [_written(value, *readable, 4) for value in values]

    def write(self, value: float, kind: str, digits: int = 4) -> str:
        """Return a value with a readable unit, as text."""
        is_time = self._meant(kind) == "time"
        readable = self.unit_of_times([value]) if is_time else self.readable(value, kind)
        return _written(value, *readable, digits)


def _written(value: float, unit: float, name: str, digits: int) -> str:
    """Return a value in a unit as text."""
    if not np.isfinite(value):
        return "infinite" if np.isinf(value) else "not computed"
    # round before formatting: 190 instead of 1.9e+02
    number = float(f"{value / unit:.{digits}g}")
    return f"{number:g} {SINGULAR.get(name, name) if number == 1 else name}".rstrip()


def units_of_table(table: Mapping[str, object], units: str) -> UnitNames:
    """Return the units of a scene's table, in which times are distances without a sliding speed."""
    load = table.get("load")
    return UnitNames.of(units, isinstance(load, Mapping) and "sliding_speed" not in load)


def without_quantities(table: Mapping[str, object], scene: type[BaseModel]) -> TomlTable:
    """Return a scene's table in which each text such as "20 mm" is a number in the scene's units.

    Parameters
    ----------
    table : mapping
        Nested table of the scene.
    scene : type
        Model whose annotations declare the unit of each key.

    Raises
    ------
    SceneError
        if the units are not units or not consistent, if a text is not a quantity of the kind that
        its key needs, or if lists or tables are nested too deeply
    """
    stated, converted_keys = table.get("units", "SI"), list[str]()
    names = units_of_table(table, stated) if isinstance(stated, str) else UnitNames()

    def convert_all(values: Mapping[str, object], path: str, declared: Key) -> TomlTable:
        keys = keys_in(declared)
        # an entry of a list of tables has its index as key, and the declaration of the list
        return {
            name: convert(entry, path + name, keys.get(name, declared if name.isdigit() else Key()))
            for name, entry in values.items()
        }

    def convert(value: object, path: str, declared: Key) -> object:
        if isinstance(value, Mapping):
            return convert_all(value, f"{path}.", declared)
        # numbers and arrays of numpy, pandas and others
        if callable(as_list := getattr(value, "tolist", None)):
            value = as_list()
        if isinstance(value, list | tuple | range):
            return [convert(entry, path, declared) for entry in value]
        # texts that do not begin with a digit, such as 'running-in', are not quantities
        if isinstance(value, str) and declared.kind in SI and re.match(r"[-+.\s]*\d", value):
            converted_keys.append(path)
            return number_of(value, path, declared.kind, names)
        return value

    try:
        converted = convert_all(table, "", Key(tables=(scene,)))
    except RecursionError:
        raise SceneError(TOO_DEEP) from None
    return {"units": "SI"} | converted if converted_keys else converted


def number_of(quantity: str, key: str, kind: str, names: UnitNames) -> float:
    """Return the value of a text such as "20 mm" in the units of a scene.

    Raises
    ------
    SceneError
        if the text is not a quantity of that kind, or if the scene has no units; the message names
        the key
    """
    number, unit = _split(quantity)
    if not number:
        raise SceneError(f"{key} = {quantity!r} is no number: give one, such as 0.5 or '20 mm'")
    if names.base is None and unit:
        raise SceneError(
            f"{key} = {quantity!r} has a unit, but the scene states that its numbers have none: "
            "give units = 'SI', or leave units out"
        )
    if not unit:
        raise SceneError(f"{key} = {quantity!r} has no unit: leave out the quotes, or add a unit")
    if re.search(r"\d\s+\d+(?!\s*/)\b|[^\W\d]\s+\d", quantity):  # pint would multiply them
        raise SceneError(f"{key} = {quantity!r} has two numbers: give one number and its unit")
    # pint would read 1,5 as fifteen
    if "," in number and re.match(r"[-+]?[1-9]\d{0,2}[.,]\d{3}\b", number):
        plain = re.sub(r"[.,](?=\d{3}\b)", "", number).replace(",", ".")
        raise SceneError(
            f"{key} = {quantity!r}: leave out separators of thousands: '{plain} {unit}', and give "
            "a point for decimals"
        )
    if "," in number:
        point = number.replace(",", ".")
        raise SceneError(f"{key} = {quantity!r}: give '{point} {unit}', with a decimal point")
    for given_kind, given_names in names.readings(kind).items():
        if (value := _in_si(quantity, given_kind)) is not None:
            return value / given_names.size(given_kind)
    if kind == "speed" and _in_si(quantity, "frequency") is not None:
        raise SceneError(
            f"{key} = {quantity!r} is a rotation, not a speed: give omega times radius, such as "
            "'0.1 m/s', with omega = 2 pi times the revolutions per second, and the distance of "
            "the punch from the axis of rotation as radius"
        )
    meant = next(iter(names.readings(kind)))
    why = ""
    if meant != kind:
        why = "; without load.sliding_speed, times are sliding distances"
    raise SceneError(
        f"{key} = {quantity!r} is no {meant.replace('_', ' ')}: {nearest_unit(unit, meant)}give "
        f"a number with a unit of {meant.replace('_', ' ')}, such as "
        f"{', '.join(list(SI[meant])[-3:])}, or a number alone{why}"
    )


def _split(quantity: str) -> tuple[str, str]:
    """Return the number at the beginning of a text, and the rest of it, the unit."""
    number = re.match(r"[-+.,\s\d]*(?:[eE][-+]?\d+)?", quantity)
    end = number.end() if number else 0
    return quantity[:end].strip(), quantity[end:].strip()


def nearest_unit(unit: str, kind: str) -> str:
    """Return the question whether a similar unit is meant; empty if none is similar.

    A letter is more often mistyped than added: "mn" means "mm" rather than "m".
    """

    def likeness(name: str) -> tuple[float, int]:
        ratio = SequenceMatcher(None, name.lower(), unit.lower()).ratio()
        return ratio, sum(map(eq, name, unit))

    match = max(SI[kind], key=likeness)
    if likeness(match)[0] < 1 and _size_in_si(unit.lower(), kind) is not None:
        match = unit.lower()
    elif likeness(match)[0] < 1:
        as_long = [name for name in SI[kind] if len(name) >= len(unit) and name[:1] == unit[:1]]
        match = max(as_long, key=likeness, default="")
        if not match or likeness(match)[0] < LEAST_LIKENESS:
            match = nearest(unit, SI[kind])
    return f"did you mean '{match}'? Else " if match else ""


@lru_cache(maxsize=64)
def _size_in_si(unit: str, kind: str) -> float | None:
    """Return the size of a unit in the SI unit of a kind; None if it is not one of that kind."""
    try:
        return float(_registry().Quantity(1.0, unit).to(_name_in_si(kind)).magnitude)
    # text that is no unit fails in many ways
    except Exception:
        return None


def _in_si(quantity: str, kind: str) -> float | None:
    """Return the value of a text in the SI unit of a kind; None if it is not of that kind."""
    try:
        return float(_registry().Quantity(quantity).to(_name_in_si(kind)).magnitude)
    # text that is no expression fails in many ways
    except Exception:
        return None


def _name_in_si(kind: str) -> str:
    return "1/s" if kind == "frequency" else UnitNames(BASE).name(kind)


@lru_cache(maxsize=1)
def _registry() -> "UnitRegistry":
    from pint import UnitRegistry

    # accept the notation of papers: mm3 and mm3/Nm
    return UnitRegistry(
        preprocessors=[
            lambda text: re.sub(r"(?<![\d.])([a-zµμ])([23])\b", r"\1^\2", text),
            lambda text: re.sub(r"\bNm\b", "(N m)", text),
        ]
    )
