"""What the commands print: the answer first, then the verdict in a line, then accuracy and cost."""

from collections.abc import Sequence

from .words import Account, Rows, shorten


def print_account(account: Account) -> None:
    """Print all that is told of a run."""
    print(f"\n{account.title}", *account.defaults, sep="\n")
    print(f"\nAnswer, by {account.answered_by} (every method's: summary.json)")
    print_lines(account.answers)
    print()
    print_table(shorten(account.rings, 16))
    print(f"\n{account.verdict_line}\n\nAccuracy and cost")
    print_table(account.methods)
    if account.agreement:
        print("\nDifferences, relative; of each quantity the pair that differs most")
        print_table(account.agreement)
    print(*account.remarks, "", sep="\n")
    print_scope(account.modelled, account.left_out)


def print_table(table: Rows) -> None:
    """Print a table with its heads."""
    print_lines([*map(list, table[:1]), *(list(row.values()) for row in table)])


def print_lines(lines: Sequence[Sequence[str]]) -> None:
    """Print lines in columns."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = (f"{cell:<{width}}" for cell, width in zip(line, widths, strict=True))
        print("  " + "   ".join(cells).rstrip())


def print_scope(modelled: list[str], left_out: dict[str, str]) -> None:
    """Print what is computed, and what is not."""
    print("Modelled", *(f"  {line}" for line in modelled), sep="\n")
    print("Left out", *(f"  {what}: {why}" for what, why in left_out.items()), sep="\n")
