"""What the commands print: the answer first, then the verdict in a line, then accuracy and cost."""

from ..crosscheck.dataset import Result
from ..crosscheck.scope import left_out, modelled
from ..problem.scene import Scene
from . import words


def print_result(result: Result) -> None:
    """The whole of a run on the terminal."""
    print(f"\n{result.scene.title or 'Untitled scene'}")
    for default in words.defaults_taken(result):
        print(default)
    lines = words.answer_lines(result)
    whats, values = (max((len(line[column]) for line in lines), default=0) for column in (0, 1))
    print(f"\nAnswer, by {words.answered_by(result)} (every method's: summary.json)")
    for line in lines:
        print(f"  {line.what:<{whats}}  {line.value:<{values}}  {line.meaning}")
    print()
    print_rows(words.ring_rows(result))
    print(f"\n{words.verdict(result)}\n\nAccuracy and cost")
    print_rows(words.method_rows(result))
    if result.agreement:
        print("\nDifferences, relative; of each quantity the pair that differs most")
        print_rows(words.agreement_rows(result))
    for text in words.remarks(result):
        print(text)
    print()
    print_scope(result.scene)


def print_rows(table: words.Rows) -> None:
    """A table in columns."""
    every = [table.headers, *table.rows]
    widths = [max(len(row[column]) for row in every) for column in range(len(table.headers))]
    numeric = [
        all(row[column][:1] in "0123456789.-" for row in table.rows)
        for column in range(len(widths))
    ]
    for row in every:
        cells = (
            f"{cell:>{width}}" if right else f"{cell:<{width}}"
            for cell, width, right in zip(row, widths, numeric, strict=True)
        )
        print("  " + "   ".join(cells).rstrip())


def print_scope(scene: Scene) -> None:
    """What is computed, and what is not."""
    print("Modelled")
    for line in modelled(scene):
        print(f"  {line}")
    print("Left out")
    for what, why in left_out(scene).items():
        print(f"  {what}: {why}")
