"""Read what scenes take from files: their text, which may be bundled, and unworn faces."""

import re
import tomllib
from importlib.resources import files
from pathlib import Path

from ....meshes.errors import SceneError
from ...tables.devices import refuse_device
from ..problem.fields import TomlTable
from ..problem.suggestions import did_you_mean
from ..problem.unit_names import units_of_table
from ..problem.written import TOO_DEEP, shown
from ..progress import LOG

# keys of a profile that say how its file is read
FLAGS = ("center", "level")
# folders of the bundled files, by what they hold
BUNDLED = {"scene": "scenes", "sweep": "sweep/files"}


def text_of(source: str | Path, kind: str = "scene") -> str:
    """Return the text of a scene or sweep file, or of a bundled one given by its name.

    Raises
    ------
    SceneError
        if there is no such file, or if it cannot be read
    """
    path, names = Path(source), bundled(kind)
    otherwise = f"give a {kind} file, or one of {', '.join(names)}"
    if not str(source).strip():
        raise SceneError(f"no name of a {kind}: {otherwise}")
    if not path.exists() and str(source) in names:
        path = Path(str(files("ringwear.studies") / BUNDLED[kind] / f"{source}.toml"))
    try:
        refuse_device(path)
        return path.read_text("utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(f"{source} is not a text file: a {kind} is TOML in UTF-8") from None
    except ValueError as error:
        raise SceneError(f"{error} that holds a {kind}") from None
    except OSError as error:
        hint = did_you_mean(source, () if path.is_dir() else names, otherwise, "")
        reason = str(error.strerror).lower()
        for other in BUNDLED:
            if other != kind and str(source) in bundled(other):
                reason = f"it is a bundled {other}"
        raise SceneError(f"{source}: {reason}; {hint.removeprefix(': ')}") from None


def tables_of(text: str, name: str) -> TomlTable:
    """Return the tables of a TOML text; `name` appears in messages.

    Raises
    ------
    SceneError
        if the text is not TOML, or if it has a value that no scene can have
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        # a key as in TOML, not as a tuple of Python
        reason = re.sub(r"\('(\w+)',\)", r"[\1]", str(error))
        place = re.search(r"at line (\d+)", reason)
        line = text.splitlines()[int(place[1]) - 1].strip() if place else ""
        location = f" in {shown(line)}" if line else ""
        raise SceneError(
            f"{name} is not TOML: {reason}{location}; give lines such as radius = 1.0, each key "
            "once, texts in quotes"
        ) from error
    # Python's limit on the digits of whole numbers
    except ValueError:
        raise SceneError(
            f"{name}: a number has thousands of digits; give numbers such as 1e6"
        ) from None
    except RecursionError:
        raise SceneError(f"{name}: {TOO_DEEP}") from None


def bundled(kind: str = "scene") -> list[str]:
    """Return the names of the scenes, or of the sweeps, that are bundled with ringwear."""
    names = (entry.name for entry in (files("ringwear.studies") / BUNDLED[kind]).iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def profile_of_file(profile: TomlTable, path: Path, table: TomlTable) -> TomlTable:
    """Return a profile with the radii and heights of its file, in the units of a scene.

    Parameters
    ----------
    profile : table of the profile, with `file` and, for a scan, `center` and `level`
    path : of the file
    table : of the scene, whose numbers have no units if it states none

    Raises
    ------
    SceneError
        if the file cannot be read, or if the profile has radii or heights as well
    """
    # most scenes have no file, and need no pandas
    from ...tables.scan import read_scan

    others = {key: value for key, value in profile.items() if key not in ("file", *FLAGS)}
    if {"radii", "heights"} & profile.keys():
        raise SceneError("punch.profile: give either file, or radii and heights, but not both")
    flags = {key: profile.get(key, False) for key in FLAGS}
    for key, value in flags.items():
        if not isinstance(value, bool):
            raise SceneError(f"punch.profile.{key} = {value!r}: give true or false")
    scan, stated = read_scan(path, **flags), table.get("units", "")
    sizes = []
    for what, unit in zip(("radii", "heights"), scan.units, strict=True):
        sizes.append(1.0)
        if unit and not (stated and isinstance(stated, str)):
            LOG.warning(
                "%s: the unit of the %s is ignored, because the numbers of the scene have no units",
                path,
                what,
            )
        elif unit:
            names = units_of_table(table, stated)
            sizes[-1] = names.size_of(unit, "length", f"{path}, the heading of the {what}")
    for note in scan.notes:
        LOG.info("%s: %s", path, note)
    radii, heights = (sizes[0] * scan.radii).tolist(), (sizes[1] * scan.heights).tolist()
    return {**others, "radii": radii, "heights": heights}


def with_profile_of_file(table: TomlTable) -> TomlTable:
    """Return the table of a scene with numbers in place of the file of the unworn face."""
    punch = table.get("punch")
    if not isinstance(punch, dict):
        return table
    profile = punch.get("profile")
    if not isinstance(profile, dict) or "file" not in profile or profile.get("kind") != "table":
        return table
    numbers = profile_of_file(profile, Path(str(profile["file"])), table)
    return {**table, "punch": {**punch, "profile": numbers}}
