"""Commands that exchange problems and results with other programs: `deck` and `challenge`."""

import argparse
from importlib import import_module
from pathlib import Path

from .output.folder import default_folder, output_folder
from .report.terminal import print_lines, print_markdown
from .scene.scene import Scene
from .status import Status

DECK_EXAMPLES = """examples:
  ringwear deck mine.toml --for calculix --out deck       the start and the last time
  ringwear deck five_rings --for calculix --time 0.1 --time 2 --size 0.05 --reach 500
  cd deck; ccx prescribed; ringwear check scene.toml prescribed.dat
"""
CHALLENGE_EXAMPLES = """examples:
  ringwear challenge                                    list the problems
  ringwear challenge 03_five_rings > mine.toml          print a problem, as a scene
  ringwear challenge 03_five_rings mine.csv             compare your results with it
  ringwear challenge 03_mine.csv                        the same, by the number in the file's name
"""


def deck(options: argparse.Namespace) -> Status:
    """Write the input files (decks) of a scene for another program."""
    # imported by its name, like the studies
    decks = import_module("ringwear.studies.decks.deck")
    scene = Scene.load(options.scene)
    times = tuple(options.times) if options.times else None
    choice = decks.Choice(options.program, options.elements, options.size, options.reach, times)
    out = options.out or default_folder(options.scene, "deck_")
    with output_folder(out, "deck", ["README.md"]) as folder:
        lines = decks.write_decks(scene, choice, folder.hidden)
    print_markdown(lines)
    print_lines(["", f"{len(folder.written)} files in {out}: {', '.join(folder.written)}"])
    return Status.DONE


def challenge(options: argparse.Namespace) -> Status:
    """List the problems of the challenge, print one as a scene, or compare results with it."""
    from .challenge.problems import problem_named, problem_of_file, problems

    match options.words:
        case []:
            for path in problems():
                print_lines([f"{path.stem:<24}{Scene.load(path).title.partition(': ')[2]}"])
        case [word] if not Path(word).is_file():
            print(problem_named(word).read_text("utf-8"), end="")
        case [*names, file] if len(names) < 2:
            path = problem_named(names[0]) if names else problem_of_file(Path(file))
            measuring = import_module("ringwear.studies.challenge.draw")
            print_markdown(measuring.submission(path, Path(file)))
        case _:
            from ..meshes.errors import SceneError

            raise SceneError("challenge takes a problem and one file: challenge [NAME] FILE")
    return Status.DONE


COMMANDS = {
    "deck": (
        "write input files of a scene for CalculiX or Abaqus, and a README that explains them",
        deck,
        ("scene", "--for PROGRAM", "--elements", "--size", "--reach", "--time", "--out"),
        None,
        DECK_EXAMPLES,
    ),
    "challenge": (
        "compare results of another program with a problem of the wear challenge",
        challenge,
        ("words",),
        None,
        CHALLENGE_EXAMPLES,
    ),
}
"""Arguments of `Command` in the command line, by the name of the command."""
