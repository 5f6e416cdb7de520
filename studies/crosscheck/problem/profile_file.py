"""Replace the file of an unworn face by its numbers, so that a scene is complete without it."""

from pathlib import Path

from ....meshes.errors import SceneError
from ..progress import LOG
from .fields import TomlTable
from .unit_names import units_of_table

# keys of a profile that say how its file is read
FLAGS = ("center", "level")


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
