"""What is told of a scene that cannot be: one line with the key, the fault, and what to write.

What people look for in a scene and ringwear does not have is told, too, and what to use instead.
"""

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from ..problem.fields import KINDS, ProfileSection, Section

# least likeness of an unknown word to the one that it is taken for, at its place and elsewhere
ALIKE, ALIKE_ELSEWHERE = 0.6, 0.75
# characters of a value that are shown
SHOWN = 60

KINDS_OF_PROFILES = [name for name, section in KINDS.items() if issubclass(section, ProfileSection)]

ROTATION = (
    "give sliding_speed of the rim, and a wear coefficient in proportion to the radius, as in the "
    "scene pin_on_disc"
)
# words in the names of keys, and what to tell of them
WORDS = {
    "friction": "ringwear has no friction: give sliding_speed, and wear coefficients that were "
    "measured with the friction there is",
    "traction": "ringwear has no friction: pressures are normal to the surface",
    "adhesion": "ringwear has no adhesion: contact presses, and does not pull",
    "adhesive": "ringwear has no adhesion: contact presses, and does not pull",
    "surface_energy": "ringwear has no adhesion: contact presses, and does not pull",
    "layer": "ringwear has no layers: the ground is one homogeneous half-space; give the modulus "
    "that an indentation as deep as yours measures",
    "coating": "ringwear has no layers: the ground is one homogeneous half-space; give the modulus "
    "that an indentation as deep as yours measures",
    "substrate": "ringwear has no layers: the ground is one homogeneous half-space",
    "thickness": "ringwear has no layers: the ground is one half-space, infinitely thick",
    "yield": "ringwear has no plasticity: compare the stresses inside, in stress.png and "
    "half_space.vtu, with the yield stress",
    "plastic": "ringwear has no plasticity: compare the stresses inside, in stress.png and "
    "half_space.vtu, with the yield stress",
    "hardness": "Archard's law is written with k = K / H: divide the dimensionless coefficient by "
    "the hardness, and give punch.wear_coefficient",
    "temperature": "ringwear has no temperature: give the wear coefficients and moduli of the hot "
    "state",
    "thermal": "ringwear has no temperature: give the wear coefficients and moduli of the hot "
    "state",
    "exponent": "the wear rate is k p v: for another power of the pressure there is no key; "
    "profile.exponent is that of a power-law face",
    "rough": "ringwear has no statistical roughness: give a measured profile, profile = { kind = "
    "'table', file = ... }",
    "viscosity": "ringwear has no viscoelasticity: give the modulus of the time that the contact "
    "takes",
    "relaxation": "ringwear has no viscoelasticity: give the modulus of the time that the contact "
    "takes",
    "angular": ROTATION,
    "rotation": ROTATION,
    "diameter": "give punch.radius, half of it",
    "shear_modulus": "give youngs_modulus = 2 G (1 + nu) with poisson_ratio = nu",
    "reduced_modulus": "give plane_strain_modulus, or punch_youngs_modulus beside youngs_modulus",
}
# keys by the names and symbols that people write
OTHER_KEYS = {
    "nu": "poisson_ratio",
    "poisson": "poisson_ratio",
    "E": "youngs_modulus",
    "modulus": "youngs_modulus",
    "E_star": "plane_strain_modulus",
    "F": "normal_force",
    "pressure": "mean_pressure",
    "p": "mean_pressure",
    "depth": "indentation",
    "v": "sliding_speed",
    "velocity": "sliding_speed",
    "k": "wear_coefficient",
    "a": "radius",
    "R": "radius",
    "time": "times",
    "dt": "step",
    "tol": "rtol",
    "tolerance": "rtol",
}
# kinds of profiles by other names
OTHER_KINDS = {
    "sphere": "a sphere is a 'parabola' (curvature_radius) where contact is small beside it, and a "
    "'ball' (ball_radius) to all digits",
    "spherical": "a sphere is a 'parabola' (curvature_radius) where contact is small beside it, "
    "and a 'ball' (ball_radius) to all digits",
    "hertz": "give 'parabola' with curvature_radius",
    "paraboloid": "give 'parabola' with curvature_radius",
    "flat": "a flat face needs no profile: leave it out",
    "annulus": "a hollow punch has punch.inner_radius",
    "hollow": "a hollow punch has punch.inner_radius",
    "fillet": "give 'rounded_rim' with flat_radius and curvature_radius",
    "conical": "give 'cone' with its slope",
}


def not_modelled(key: str) -> str | None:
    """Return what to do instead of a key that does not exist; None if nothing is known."""
    return next((told for word, told in WORDS.items() if word in key.lower()), None)


def kind_instead(given: object) -> str:
    """Return which kind of profile to give in place of one that does not exist."""
    kind = given.get("kind") if isinstance(given, Mapping) else None
    if kind is None:
        return "is missing"
    if (told := OTHER_KINDS.get(str(kind).lower())) is not None:
        return told
    return f"there is no kind {kind!r}{question(str(kind), KINDS_OF_PROFILES)}"


def nearest(word: str, words: Iterable[str], alike: float = ALIKE) -> str:
    """Return the word that is most like one, whatever its case; empty if none is like it."""
    by_lower = {known.lower().replace("-", "_"): known for known in words}
    lower = word.lower().replace("-", "_").replace(" ", "_")
    near = difflib.get_close_matches(lower, by_lower, 1, alike)
    if not near and len(word) > 2:
        near = [known for known in by_lower if lower in known]
    return by_lower[near[0]] if near else ""


def question(word: str, words: Iterable[str]) -> str:
    """Return the question whether the most like of some words is meant; empty if none is."""
    near = nearest(word, words)
    return f": did you mean '{near}'?" if near else ""


def explain(error: ValidationError, scene: type[Section]) -> str:
    """Return one line for a scene's first fault: the key, the value, the fault and the remedy.

    The keys of other faults are named at its end.
    """
    errors = error.errors(include_url=False)
    # a misspelt key also leaves its right name missing: tell the misspelling first
    first = min(errors, key=lambda item: item["type"] != "extra_forbidden")
    others = dict.fromkeys(key_of(item) for item in errors if item["type"] != "missing")
    others.pop(key_of(first), None)
    also = f"; also wrong: {', '.join(filter(None, others))}" if any(others) else ""
    return _fault(first, errors, scene) + also


def _fault(fault: ErrorDetails, errors: list[ErrorDetails], scene: type[Section]) -> str:
    """Return a fault in a line; keys that are missing are told together."""
    key, kind = key_of(fault), fault["type"]
    section, field = declaration([str(part) for part in fault["loc"]], scene)
    description = field.description if field is not None else None
    if kind == "extra_forbidden":
        return f"unknown key {key}: {_in_place_of(str(fault['loc'][-1]), section, scene)}"
    if kind == "missing":
        missing = [key_of(item) for item in errors if item["type"] == "missing"]
        one = len(missing) == 1 and description
        keys = f" {key}; give {description}" if one else f"s {', '.join(missing)}"
        return (
            f"missing key{keys}; needed are, for example, punch = {{ radius = 1.0, rings = 5, "
            "wear_coefficients = [1.0, 10.0] }, half_space = { plane_strain_modulus = 1.0 }, load "
            "= { normal_force = 2.0 }, and wear = { times = [0.0, 0.1, 1.0] } for a history"
        )
    message = _in_plain_words(fault)
    remedy = description or REMEDIES.get(kind, "")
    if kind == "value_error":
        # what is wrong with a table says its remedy itself
        remedy = "" if isinstance(fault["input"], Mapping) or "give " in message else remedy
        told = f"{key}: {message}" if key else message
    elif kind.startswith("union_tag"):
        told = f"{key}.kind: {kind_instead(fault['input'])}"
    else:
        told = f"{key} = {shown(fault['input'])}: {message}"
    if not remedy:
        return told
    return f"{told} Else give {remedy}" if told.endswith("?") else f"{told}; give {remedy}"


# of faults that keys may have without a description
REMEDIES = {
    "string_type": "a text, in quotes",
    "bool_type": "true or false",
    "model_type": "its keys in braces, or below a heading in brackets",
}


def _in_plain_words(fault: ErrorDetails) -> str:
    """Return what is wrong with a value, in words of scenes."""
    if fault["type"] == "model_type":
        return "should be a table"
    if fault["type"] == "model_attributes_type":
        return "should be a table with a kind"
    if fault["type"] == "literal_error":
        words = re.findall(r"'(.*?)'", fault["ctx"]["expected"])
        meant = question(str(fault["input"]), words)
        return f"should be one of {', '.join(words)}{meant}"
    if fault["type"] == "list_type":
        return f"should be a list{question(str(fault['input']), ['running-in'])}"
    message = fault["msg"].removeprefix("Value error, ").replace("0.000000001", "1e-9")
    if fault["type"] == "value_error":
        return message
    return message.replace("Input should", "should").replace("List should", "should")


def shown(value: object) -> str:
    """Return a value as text, cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 4]} ..."


def _in_place_of(unknown: str, section: type[Section], scene: type[Section]) -> str:
    """Return what to write in place of an unknown key: of its own table or of another."""
    if (instead := not_modelled(unknown)) is not None:
        return instead
    names = keys_of(section)
    there = f"the keys here are {', '.join(names)}"
    near = place_of(unknown, section, scene)
    return f"did you mean {near}? Else {there}" if near else there


def place_of(unknown: str, section: type[Section], scene: type[Section]) -> str:
    """Return the key of a table that an unknown key stands for, or one such as ``punch.rings``.

    Empty if it is like no key.
    """
    names, word = keys_of(section), OTHER_KEYS.get(unknown, unknown)
    if word in names:
        return word
    tables = {
        info.alias or name: keys_of(info.annotation)
        for name, info in scene.model_fields.items()
        if isinstance(info.annotation, type) and issubclass(info.annotation, Section)
    }
    for table, others in tables.items():
        if word in others:
            return f"{table}.{word}"
    if near := nearest(word, names):
        return near
    for table, others in tables.items():
        if near := nearest(word, others, ALIKE_ELSEWHERE):
            return f"{table}.{near}"
    return ""


def keys_of(section: type[Section]) -> list[str]:
    """Return the keys of a table, as they are written."""
    return [info.alias or name for name, info in section.model_fields.items()]


def key_of(error: ErrorDetails) -> str:
    """Return the key that an error is about, as it is written: without the kind of a profile."""
    return ".".join(str(part) for part in error["loc"] if part not in KINDS)


def declaration(
    location: Sequence[str], scene: type[Section]
) -> tuple[type[Section], FieldInfo | None]:
    """Return the section that a location lies in, and the field of its innermost known key."""
    section, field = scene, None
    for part in location:
        if part in KINDS:
            section = KINDS[part]
            continue
        names = {info.alias or name: info for name, info in section.model_fields.items()}
        if part.isdigit():  # one of a list of tables, or of values
            continue
        if part not in names:
            break
        field = names[part]
        # a table that may be left out has `None` beside its own type
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, Section):
                section = kind
    return section, field
