"""Print results on the terminal: first the answer, then the verdict, then everything else."""

from collections.abc import Sequence

from ..crosscheck import Account, Rows, columns
from .terminal import broken, print_lines, terminal_width

# characters that a meaning needs to the right of its number; on narrower terminals it is printed
# below the number
LEAST_MEANING = 28


def print_answers(answers: Sequence[tuple[str, str, str]]) -> None:
    """Print name, value and meaning of each answer; on a narrow terminal the meaning is below."""
    width = terminal_width()
    numbers = columns([answer[:2] for answer in answers])
    longest = max(map(len, numbers), default=0)
    for number, (*_, meaning) in zip(numbers, answers, strict=True):
        heading = f"{number:<{longest}}   "
        if not width or width - len(heading) >= LEAST_MEANING:
            print(broken(meaning, heading, " " * len(heading)).rstrip())
        else:
            print(number, broken(meaning, " " * 6, " " * 6), sep="\n")


def print_account(account: Account, verbose: bool, page: bool = True) -> None:
    """Print the answer, the verdict and the remarks; if `verbose`, the whole account of a run.

    `page` is whether the page `report.html` is written, too.
    """
    print_lines(["", account.title, *account.defaults, ""])
    if account.answers:
        print_answers(account.answers[:6])
    else:
        # a load that varies has no numbers of its own; what each ring has lost is the answer then
        print_table(account.rings)
    print_lines(["", account.verdict_line])
    if not verbose:
        print_lines(account.remarks)
        files = ("report.html", "summary.json") if page else ("summary.json",)
        more = ", ".join(("--verbose", *files))
        print_lines([f"Method: {account.answered_by}. More: {more}"])
        return
    print(f"\nAll answers, by {account.answered_by}")
    print_answers(account.answers)
    print()
    print_table(account.rings)
    print("\nAccuracy and cost")
    print_table(account.methods)
    if account.agreement:
        print("\nRelative differences, for each quantity of the two methods that differ most")
        print_table(account.agreement)
    print_lines([*account.remarks, ""])
    print_scope(account.modelled, account.left_out)


def print_table(table: Rows) -> None:
    """Print a table with its headings; if it is wider than the terminal, print it row by row."""
    lines = columns([*map(list, table[:1]), *(list(row.values()) for row in table)])
    width = terminal_width()
    if not width or max(map(len, lines), default=0) <= width:
        print_lines(lines)
        return
    for row in table:
        (_, first), *others = row.items()
        print_lines([f"  {first}", *(f"    {head}: {cell}" for head, cell in others if cell)])


def print_scope(modelled: list[str], left_out: dict[str, str]) -> None:
    """Print what is modelled and what is left out."""
    print_lines(["Modelled", *(f"  {line}" for line in modelled)])
    print_lines(["Left out", *(f"  {item}: {reason}" for item, reason in left_out.items())])
