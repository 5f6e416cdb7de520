"""The packages of the extra `sweep`, which only large sweeps need."""

from importlib.util import find_spec

from ...meshes import SceneError


def require(packages: tuple[str, ...], purpose: str) -> None:
    """Raise an error if a package of the extra `sweep` is not installed.

    Parameters
    ----------
    packages : names of the packages
    purpose : what needs them, the subject of the message

    Raises
    ------
    SceneError
        its message says how to install them
    """
    missing = [name for name in packages if not _is_installed(name)]
    if missing:
        raise SceneError(
            f"{purpose} needs {' and '.join(missing)}: install the extra `sweep`, "
            "pip install 'ringwear[sweep]'"
        )


def _is_installed(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ValueError:
        # the import of the package is blocked
        return False
