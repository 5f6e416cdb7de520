"""Find the problems of the challenge by their names."""

import re
from pathlib import Path

from ...meshes import SceneError

FOLDER = Path(__file__).parent
OTHERS = FOLDER / "others"


def problems() -> list[Path]:
    """Return the scene files of all problems, in order."""
    return sorted(FOLDER.glob("[0-9][0-9]_*.toml"))


def number_of(problem: Path) -> int:
    """Return the number of a problem."""
    return int(problem.name[:2])


def difficulty(problem: Path) -> str:
    """Return the difficulty of a problem: the comment in the first line of its scene file."""
    return problem.read_text("utf-8").partition("\n")[0].removeprefix("# ").rstrip(".")


def problem_named(name: str) -> Path:
    """Return the scene file of a problem: ``03_five_rings``, ``five_rings`` or ``3``.

    Raises
    ------
    SceneError
        if there is no such problem; it lists the names of all
    """
    for path in problems():
        if name in (path.stem, path.stem[3:]) or (name.isdigit() and int(name) == number_of(path)):
            return path
    names = ", ".join(path.stem for path in problems())
    raise SceneError(
        f"{name} is neither a file nor a problem of the challenge: give one of {names}"
    )


def problem_of_file(file: Path) -> Path:
    """Return the problem whose number is at the start of a file name, as in ``03_mine.csv``.

    Raises
    ------
    SceneError
        if the name does not begin with the number of a problem
    """
    number = re.match(r"(\d\d)[_-]", file.name)
    if number is None:
        raise SceneError(
            f"{file.name} has no number of a problem in its name: give the problem, too, as in "
            f"challenge 03_five_rings {file.name}, or begin the name with 03_"
        )
    return problem_named(number[1])
