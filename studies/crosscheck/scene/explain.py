"""Explain errors in a scene in one line: the key, the error, and what to write instead.

Keys for features that ringwear does not have are answered by what to use instead.
"""

import re
from collections.abc import Mapping, Sequence
from typing import get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from ..problem.fields import KINDS, ProfileSection, Section
from ..problem.suggestions import did_you_mean, nearest
from ..problem.written import shown

# least similarity of an unknown key to the suggested one in another table
LEAST_SIMILARITY_ELSEWHERE = 0.75

KINDS_OF_PROFILES = [name for name, section in KINDS.items() if issubclass(section, ProfileSection)]

ROTATION = (
    "give sliding_speed = omega times radius, the distance of the punch from the axis of rotation, "
    "as in the scene pin_on_disc; if the punch turns about its own axis, give the speed of the rim "
    "and a wear coefficient in proportion to the radius, as in the scene rotating_pin"
)
BONDED = (
    "layers are bonded to each other and to the base, and no other interface is modelled: leave it "
    "out, there is nothing to give"
)
BOTH_WEAR = (
    "wear is that of the punch: if both bodies wear, give the sum of both coefficients as "
    "punch.wear_coefficient, or for each ring as punch.wear_coefficients"
)
# advice by words in the names of unknown keys
WORDS = {
    "friction": "ringwear has no friction: give sliding_speed, and wear coefficients measured with "
    "the actual friction",
    "traction": "ringwear has no friction: pressures are normal to the surface",
    "adhesion": "ringwear has no adhesion: contact presses, and does not pull",
    "adhesive": "ringwear has no adhesion: contact presses, and does not pull",
    "surface_energy": "ringwear has no adhesion: contact presses, and does not pull",
    "layer": "layers are tables: [[half_space.layers]] with thickness, youngs_modulus and "
    "poisson_ratio, from the surface down; half_space describes the base below them",
    "coating": "a coating is a layer: [[half_space.layers]] with thickness, youngs_modulus and "
    "poisson_ratio; half_space describes the base below it",
    "substrate": "the substrate is half_space itself; the layers on it are [[half_space.layers]]",
    "thickness": "a thickness belongs to a layer: [[half_space.layers]] with thickness, "
    "youngs_modulus and poisson_ratio; half_space.rigid = true for a rigid base",
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
    "exponent": "the wear rate is k p v: another power of the pressure is not possible; "
    "profile.exponent is the exponent of a power-law face",
    "rough": "ringwear has no statistical roughness: give a measured profile, profile = { kind = "
    "'table', file = ... }",
    "viscosity": "ringwear has no viscoelasticity: give the modulus at the time scale of the "
    "contact",
    "relaxation": "ringwear has no viscoelasticity: give the modulus at the time scale of the "
    "contact",
    "angular": ROTATION,
    "rotation": ROTATION,
    "omega": ROTATION,
    "rpm": ROTATION,
    "revolution": ROTATION,
    "diameter": "give punch.radius, half of it",
    "shear_modulus": "give youngs_modulus = 2 G (1 + nu) with poisson_ratio = nu",
    "reduced_modulus": "give plane_strain_modulus, or youngs_modulus and punch_youngs_modulus",
}
# keys by other names and symbols that users may write
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
# prefix of the keys of layers, and these keys by other names that users may write
LAYER = "half_space.layers.0."
KEYS_OF_LAYERS = {"height": "thickness", "depth": "thickness", "h": "thickness", "t": "thickness"}
# advice by words in the names of unknown keys of a table, by the prefix of the table; it comes
# before that of `WORDS`
OF_GROUND = {
    "wear": BOTH_WEAR,
    **dict.fromkeys(("bond", "interface", "delamination", "slip"), BONDED),
}
WORDS_OF_TABLES = {
    "half_space.": OF_GROUND,
    LAYER: OF_GROUND
    | {"plane_strain_modulus": "give youngs_modulus = E* (1 - nu^2) with poisson_ratio = nu"},
}
# advice by other names of kinds of profiles
OTHER_KINDS = {
    "sphere": "a sphere is a 'parabola' (curvature_radius) if its radius is much greater than that "
    "of the contact, and exactly a 'ball' (ball_radius)",
    "spherical": "a sphere is a 'parabola' (curvature_radius) if its radius is much greater than "
    "that of the contact, and exactly a 'ball' (ball_radius)",
    "hertz": "give 'parabola' with curvature_radius",
    "paraboloid": "give 'parabola' with curvature_radius",
    "flat": "a flat face needs no profile: leave it out",
    "annulus": "a hollow punch has punch.inner_radius",
    "hollow": "a hollow punch has punch.inner_radius",
    "fillet": "give 'rounded_rim' with flat_radius and curvature_radius",
    "conical": "give 'cone' with its slope",
}


def not_modelled(key: str, prefix: str = "") -> str | None:
    """Return advice for a key of a feature that ringwear does not have; None if there is none.

    Parameters
    ----------
    key : the unknown key, without the name of its table
    prefix : of the table in which it is, such as ``half_space.``
    """
    names = key.lower(), OTHER_KEYS.get(key, "")
    for words in (WORDS_OF_TABLES.get(prefix, {}), WORDS):
        for word, advice in words.items():
            if any(word in name for name in names):
                return advice
    return None


def kind_instead(profile: object) -> str:
    """Return advice for a profile whose kind is missing or does not exist."""
    kind = profile.get("kind") if isinstance(profile, Mapping) else None
    if kind is None:
        return "is missing"
    if (advice := OTHER_KINDS.get(str(kind).lower())) is not None:
        return advice
    return f"there is no kind {shown(kind)}{did_you_mean(str(kind), KINDS_OF_PROFILES)}"


def explain(error: ValidationError, scene: type[Section]) -> str:
    """Return one line about the first error in a scene: the key, the value, the error, the remedy.

    The keys of further errors are listed at its end.

    Parameters
    ----------
    error : ValidationError
        Errors that pydantic found.
    scene : type
        Model of the scene.
    """
    errors = error.errors(include_url=False)
    # a misspelt key is also missing under its right name: report the misspelling first
    first = min(errors, key=lambda item: item["type"] != "extra_forbidden")
    others = dict.fromkeys(key_of(item) for item in errors if item["type"] != "missing")
    others.pop(key_of(first), None)
    further = f"; also wrong: {', '.join(filter(None, others))}" if any(others) else ""
    return _fault(first, errors, scene) + further


def _fault(fault: ErrorDetails, errors: list[ErrorDetails], scene: type[Section]) -> str:
    """Return a line about an error; all missing keys are listed in the same line."""
    key, kind = key_of(fault), fault["type"]
    section, field = declaration([str(part) for part in fault["loc"]], scene)
    description = field.description if field is not None else None
    if kind == "extra_forbidden":
        return f"unknown key {key}: {_in_place_of(str(fault['loc'][-1]), section, scene)}"
    if kind == "missing":
        missing = [key_of(item) for item in errors if item["type"] == "missing"]
        single = len(missing) == 1 and description
        keys = f" {key}; give {description}" if single else f"s {', '.join(missing)}"
        if all(name.count(".") > 1 for name in missing):
            # keys of a profile, a layer, or a load over time
            remedy = "" if single else f"; give {description}"
            return f"missing key{keys}{remedy}"
        return (
            f"missing key{keys}; a scene needs, for example, punch = {{ radius = 1.0, rings = 5, "
            "wear_coefficients = [1.0, 10.0] }, half_space = { plane_strain_modulus = 1.0 }, load "
            "= { normal_force = 2.0 }, and wear = { times = [0.0, 0.1, 1.0] } for a history"
        )
    message = _in_plain_words(fault)
    remedy = description or REMEDIES.get(kind, "")
    if kind == "value_error":
        # messages about tables already contain a remedy
        remedy = "" if isinstance(fault["input"], Mapping) or "give " in message else remedy
        line = f"{key}: {message}" if key else message
    elif kind.startswith("union_tag"):
        line = f"{key}.kind: {kind_instead(fault['input'])}"
    else:
        line = f"{key} = {shown(fault['input'])}: {message}"
    if not remedy:
        return line
    return f"{line} Else give {remedy}" if line.endswith("?") else f"{line}; give {remedy}"


# remedies by type of error, for keys without a description
REMEDIES = {
    "string_type": "a text, in quotes",
    "bool_type": "true or false",
    "model_type": "its keys in braces, or below a heading in brackets",
}


def _in_plain_words(fault: ErrorDetails) -> str:
    """Return what is wrong with a value, in plain words instead of pydantic's."""
    if fault["type"] == "model_type":
        return "should be a table"
    if fault["type"] == "model_attributes_type":
        return "should be a table with a kind"
    if fault["type"] == "literal_error":
        words = re.findall(r"'(.*?)'", fault["ctx"]["expected"])
        suggestion = did_you_mean(str(fault["input"]), words)
        return f"should be one of {', '.join(words)}{suggestion}"
    if fault["type"] == "list_type":
        return f"should be a list{did_you_mean(str(fault['input']), ['running-in'])}"
    message = fault["msg"].removeprefix("Value error, ").replace("0.000000001", "1e-9")
    message = message.replace(" after validation", "")
    if fault["type"] == "value_error":
        return message
    return re.sub(r"\b(?:Input|List|Value) should", "should", message)


def _in_place_of(unknown: str, section: type[Section], scene: type[Section]) -> str:
    """Return what to write instead of an unknown key, in its own table or in another one."""
    advice = not_modelled(unknown, section.prefix)
    # advice on layers is of no use within a layer
    if advice is not None and not (section.prefix == LAYER and "[[half_space.layers]]" in advice):
        return advice
    names = keys_of(section)
    known_keys = f"the keys here are {', '.join(names)}"
    match = place_of(unknown, section, scene)
    return f"did you mean {match}? Else {known_keys}" if match else known_keys


def place_of(unknown: str, section: type[Section], scene: type[Section]) -> str:
    """Return the key that an unknown key probably means.

    It is a key of the table `section`, or one of another table such as ``punch.rings``. The result
    is empty if no key is similar.
    """
    names, word = keys_of(section), OTHER_KEYS.get(unknown, unknown)
    if section.prefix == LAYER:
        word = KEYS_OF_LAYERS.get(unknown, word)
    if word in names:
        return word
    tables = {
        info.alias or name: keys_of(info.annotation)
        for name, info in scene.model_fields.items()
        if isinstance(info.annotation, type) and issubclass(info.annotation, Section)
    }
    match = nearest(word, names)
    if match and section not in (scene, *(info.annotation for info in scene.model_fields.values())):
        # in a table within a table, such as a profile, its own keys come first
        return match
    for table, keys in tables.items():
        if word in keys:
            return f"{table}.{word}"
    if match:
        return match
    for table, keys in tables.items():
        if match := nearest(word, keys, LEAST_SIMILARITY_ELSEWHERE):
            return f"{table}.{match}"
    return ""


def key_meant(key: str, scene: type[Section]) -> str:
    """Return the key of a scene that an unknown key with dots probably means; empty if none is."""
    place = ""
    for part in key.split("."):
        section, _ = declaration(place.split("."), scene) if place else (scene, None)
        meant = part if place and part.isdigit() else place_of(part, section, scene)
        # a key of another table is no part of this one
        if not meant or (place and "." in meant):
            return ""
        place = f"{place}.{meant}" if place else meant
    return place


def keys_of(section: type[Section]) -> list[str]:
    """Return the keys of a table, as they are written in scenes."""
    return [info.alias or name for name, info in section.model_fields.items()]


def key_of(error: ErrorDetails) -> str:
    """Return the key of an error as it is written in scenes, without the kind of a profile."""
    return ".".join(str(part) for part in error["loc"] if part not in KINDS)


def declaration(
    location: Sequence[str], scene: type[Section]
) -> tuple[type[Section], FieldInfo | None]:
    """Return the section that contains a location, and the field of its innermost known key."""
    section, field = scene, None
    for part in location:
        if part in KINDS:
            section = KINDS[part]
            continue
        names = {info.alias or name: info for name, info in section.model_fields.items()}
        if part.isdigit():  # index in a list of tables or values
            continue
        if part not in names:
            break
        field = names[part]
        # the type of an optional table is a union with None
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, Section):
                section = kind
    return section, field
