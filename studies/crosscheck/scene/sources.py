"""Read the text of scenes from files, or from the scenes bundled with ringwear."""

import re
import tomllib
from importlib.resources import files
from pathlib import Path

from ....meshes.errors import SceneError
from ...tables.devices import refuse_device
from ..problem.fields import TomlTable
from ..problem.suggestions import did_you_mean
from ..problem.written import TOO_DEEP, shown


def text_of(source: str | Path) -> str:
    """Return the TOML text of a scene file, or of a bundled scene given by its name.

    Raises
    ------
    SceneError
        if there is no such file or scene, or if the file cannot be read
    """
    if not str(source).strip():
        raise SceneError(f"no name of a scene: give a scene file, or one of {', '.join(bundled())}")
    path = Path(source)
    if not path.exists() and str(source) in bundled():
        path = Path(str(files("ringwear.studies"))) / "scenes" / f"{source}.toml"
    try:
        refuse_device(path)
        return path.read_text("utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(f"{source} is not a text file: a scene is TOML in UTF-8") from None
    except ValueError as error:
        raise SceneError(f"{error} that holds a scene") from None
    except OSError as error:
        names = bundled()
        otherwise = f"give a scene file, or one of {', '.join(names)}"
        hint = did_you_mean(source, () if path.is_dir() else names, otherwise, "")
        reason = str(error.strerror).lower()
        raise SceneError(f"{source}: {reason}; {hint.removeprefix(': ')}") from None


def tables_of(text: str) -> TomlTable:
    """Return the tables of a TOML text.

    Raises
    ------
    ValueError
        if the text is not TOML, or if it has a value that no scene can have; a TOMLDecodeError has
        the place in the text
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    # Python's limit on the digits of whole numbers
    except ValueError:
        raise ValueError("a number has thousands of digits; give numbers such as 1e6") from None
    except RecursionError:
        raise ValueError(TOO_DEEP) from None


def line_of(error: tomllib.TOMLDecodeError, text: str) -> str:
    """Return the line of an error in TOML text, and an example of correct lines."""
    place = re.search(r"at line (\d+)", str(error))
    line = text.splitlines()[int(place[1]) - 1].strip() if place else ""
    location = f" in {shown(line)}" if line else ""
    return f"{location}; give lines such as radius = 1.0, each key once, texts in quotes"


def bundled() -> list[str]:
    """Return the names of the scenes bundled with ringwear."""
    names = (entry.name for entry in (files("ringwear.studies") / "scenes").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))
