"""Sweep files that come with ringwear, and those of the user."""

from importlib.resources import files
from pathlib import Path

from ...meshes.errors import SceneError


def bundled_sweeps() -> list[str]:
    """Names of the sweeps that come with ringwear."""
    names = (entry.name for entry in (files("ringwear.studies") / "sweep" / "files").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def sweep_text(source: str | Path) -> str:
    """The text of a sweep file, or of a bundled one by its name."""
    path = Path(source)
    if not path.exists() and str(source) in bundled_sweeps():
        return (files("ringwear.studies") / "sweep" / "files" / f"{source}.toml").read_text("utf-8")
    try:
        return path.read_text("utf-8")
    except FileNotFoundError:
        known = ", ".join(bundled_sweeps())
        raise SceneError(f"{source}: no such file, and no bundled sweep ({known})") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(
            f"{source} cannot be read: {error}; give a sweep file, TOML in UTF-8"
        ) from error
