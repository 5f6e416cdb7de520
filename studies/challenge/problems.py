"""Find the problems of the challenge by their names.

Problems on a half-space are scene files. Problems on layered ground are folders, which contain a
scene, the statement of the problem and its answers.
"""

import re
from pathlib import Path

from ...meshes import SceneError

FOLDER = Path(__file__).parent
SCENE = "scene.toml"
"""Name of the scene file in the folder of a problem."""


def problems() -> list[Path]:
    """Return the scene files of all problems, in order."""
    files = [*FOLDER.glob("[0-9][0-9]_*.toml"), *FOLDER.glob(f"[0-9][0-9]_*/{SCENE}")]
    return sorted(files, key=problem_name)


def problem_name(problem: Path) -> str:
    """Return the name of a problem, such as ``03_five_rings``: that of its file or folder."""
    return problem.parent.name if problem.name == SCENE else problem.stem


def number_of(problem: Path) -> int:
    """Return the number of a problem."""
    return int(problem_name(problem)[:2])


def answers_of(problem: Path) -> Path:
    """Return the table of answers of a problem, which only problems on layered ground have."""
    return problem.with_name("answers.csv")


def problem_named(name: str) -> Path:
    """Return the scene file of a problem: ``03_five_rings``, ``five_rings`` or ``3``.

    Raises
    ------
    SceneError
        if there is no such problem; it lists the names of all
    """
    for path in problems():
        numbered = name.isdigit() and int(name) == number_of(path)
        if numbered or name in (problem_name(path), problem_name(path)[3:]):
            return path
    names = ", ".join(map(problem_name, problems()))
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
