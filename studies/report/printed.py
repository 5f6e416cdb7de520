"""What the commands print: the answer first, then the verdict in a line, then whatever else."""

from .words import Account, Rows, columns


def print_account(account: Account, verbose: bool) -> None:
    """Print the answer, the verdict, and what bears on it; or all that is told of a run."""
    title, *answers, verdict = account.brief
    print(f"\n{title}", *account.defaults, "", *answers, f"\n{verdict}", sep="\n")
    if not verbose:
        print(*account.remarks, sep="\n")
        print(f"By {account.answered_by}; all else: --verbose, report.html, summary.json")
        return
    print(f"\nAll answers, by {account.answered_by}", *columns(account.answers), "", sep="\n")
    print_table(account.rings)
    print("\nAccuracy and cost")
    print_table(account.methods)
    if account.agreement:
        print("\nDifferences, relative; of each quantity the pair that differs most")
        print_table(account.agreement)
    print(*account.comparisons, *account.remarks, "", sep="\n")
    print_scope(account.modelled, account.left_out)


def print_table(table: Rows) -> None:
    """Print a table with its heads."""
    print(*columns([*map(list, table[:1]), *(list(row.values()) for row in table)]), sep="\n")


def print_scope(modelled: list[str], left_out: dict[str, str]) -> None:
    """Print what is computed, and what is not."""
    print("Modelled", *(f"  {line}" for line in modelled), sep="\n")
    print("Left out", *(f"  {what}: {why}" for what, why in left_out.items()), sep="\n")
