"""Explain errors in a scene in one line: the key, the error, and what to write instead."""

import re
from collections.abc import Mapping, Sequence
from typing import get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from ..problem.fields import KINDS, Section
from ..problem.suggestions import did_you_mean, nearest
from ..problem.written import shown

# least similarity of an unknown key to the suggested one in another table
LEAST_SIMILARITY_ELSEWHERE = 0.75


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
        line = f"{key}.kind: {message}"
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
    if fault["type"] == "union_tag_not_found":
        return "is missing"
    if fault["type"] == "union_tag_invalid":
        tag, kinds = fault["ctx"]["tag"], _quoted(fault["ctx"]["expected_tags"])
        return f"there is no kind {shown(tag)}{did_you_mean(tag, kinds)}"
    if fault["type"] == "literal_error":
        words = _quoted(fault["ctx"]["expected"])
        suggestion = did_you_mean(str(fault["input"]), words)
        return f"should be one of {', '.join(words)}{suggestion}"
    if fault["type"] == "list_type":
        return f"should be a list{did_you_mean(str(fault['input']), ['running-in'])}"
    message = fault["msg"].removeprefix("Value error, ").replace("0.000000001", "1e-9")
    message = message.replace(" after validation", "")
    if fault["type"] == "value_error":
        return message
    return re.sub(r"\b(?:Input|List|Value) should", "should", message)


def _quoted(text: str) -> list[str]:
    """Return the words in quotes of a text."""
    return re.findall(r"'(.*?)'", text)


def _in_place_of(unknown: str, section: type[Section], scene: type[Section]) -> str:
    """Return what to write instead of an unknown key, in its own table or in another one."""
    known_keys = f"the keys here are {', '.join(keys_of(section))}"
    match = place_of(unknown, section, scene)
    return f"did you mean {match}? Else {known_keys}" if match else known_keys


def place_of(unknown: str, section: type[Section], scene: type[Section]) -> str:
    """Return the key that an unknown key probably means.

    It is a key of the table `section`, or one of another table such as ``punch.rings``. The result
    is empty if no key is similar.
    """
    names = keys_of(section)
    if unknown in names:
        return unknown
    tables = [
        info.annotation
        for info in scene.model_fields.values()
        if isinstance(info.annotation, type) and issubclass(info.annotation, Section)
    ]
    match = nearest(unknown, names)
    if match and section not in (scene, *tables):
        # in a table within a table, such as a profile, its own keys come first
        return match
    for table in tables:
        if unknown in keys_of(table):
            return table.prefix + unknown
    if match:
        return match
    for table in tables:
        if match := nearest(unknown, keys_of(table), LEAST_SIMILARITY_ELSEWHERE):
            return table.prefix + match
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
