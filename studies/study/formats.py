"""Write tables of studies in Markdown and LaTeX, for papers and notes."""

from itertools import groupby

import pandas as pd

from ..report.template import as_text

SYMBOLS = str.maketrans(
    {
        "ν": r"$\nu$",
        "Δ": r"$\Delta$",
        "×": r"$\times$",
        "²": r"$^2$",
        "³": r"$^3$",
        "·": r"$\cdot$",
        "≤": r"$\le$",
        "≥": r"$\ge$",
        "−": "$-$",
        "∞": r"$\infty$",
        "λ": r"$\lambda$",
    }
)
"""Symbols that plain LaTeX cannot read, and the code that prints each of them."""


WIDTH, MOST_LINES = 100, 40
"""Greatest width of a table in letters, and its greatest number of lines on a terminal."""
MOST_COLUMNS, LATEX_WIDTH = 5, 80
"""Greatest number of columns, and greatest width of a row in LaTeX."""


def blocks(table: pd.DataFrame, width: int = WIDTH) -> list[pd.DataFrame]:
    """Return a table as several of up to `MOST_COLUMNS` columns, each with the first column.

    Columns ``TITLE: NAME`` become columns NAME of a table whose first column is headed by TITLE.
    Each value of a first column `case` heads tables of its own. Rows and columns without an entry
    are left out.
    """
    if table.empty:
        # a study that was stopped has no results of a level
        return []
    parts, cases = list[pd.DataFrame](), [("", table)]
    if "case" in table.columns[:1]:
        cases = list(table.drop(columns="case").groupby(table["case"], sort=False))
    first, *others = cases[0][1].columns
    for title, names in groupby(others, lambda name: str(name).rpartition(": ")[0]):
        listed = [first, *names]
        for case, rows in cases:
            part = rows[listed].replace("", None).dropna(axis="columns", how="all")
            if title:
                part = part.dropna(how="all", subset=part.columns[1:])
            head = ": ".join(filter(None, (str(case), title))) or first
            shorter = [str(name).removeprefix(f"{title}: ") for name in part.columns[1:]]
            part.columns = pd.Index([head, *shorter])
            parts += _of_width(part, width)
    return parts


def _of_width(table: pd.DataFrame, most: int) -> list[pd.DataFrame]:
    """Return a table as several of up to a width in letters; none if it has one column only."""
    rows, parts = [list(map(str, table.columns)), *cells(table)], list[list[int]]()
    widths = [3 + max(map(len, column)) for column in zip(*rows, strict=True)]
    for number, width in enumerate(widths[1:], 1):
        used = 1 + widths[0] + sum(widths[each] for each in parts[-1]) if parts else most
        if used + width > most or len(parts[-1]) == MOST_COLUMNS - 1:
            parts.append([])
        parts[-1].append(number)
    return [table.iloc[:, [0, *part]] for part in parts]


def for_terminal(table: pd.DataFrame) -> list[str]:
    """Return the first blocks of a table in Markdown, in up to `MOST_LINES` lines."""
    lines, texts = list[str](), [to_markdown(block).splitlines() for block in blocks(table)]
    for text in texts:
        if lines and len(lines) + len(text) + 2 > MOST_LINES:
            break
        lines += [*([""] if lines else []), *text]
    if len(lines) < sum(map(len, texts)):
        lines = [*lines[: MOST_LINES - 1], "The other columns and rows are in answer.md."]
    return lines


def to_markdown(table: pd.DataFrame) -> str:
    """Return a table in the pipe syntax of Markdown, with aligned columns."""
    rows = [[str(name) for name in table.columns], *cells(table)]
    rows = [[cell.replace("|", r"\|") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    rows.insert(1, ["-" * width for width in widths])
    return "".join(f"| {' | '.join(map(str.ljust, row, widths))} |\n" for row in rows)


def to_latex(table: pd.DataFrame) -> str:
    """Return a table as a `tabular` with the rules of the package `booktabs`.

    Texts are escaped, except parts between dollar signs, which are formulas already.
    """

    def written(cell: object) -> str:
        return as_text(cell).translate(SYMBOLS)

    styled = table.reset_index(drop=True).style.hide(axis="index")
    styled = styled.format(written, escape="latex-math")
    return styled.format_index(written, axis=1, escape="latex-math").to_latex(hrules=True)


def cells(table: pd.DataFrame) -> list[list[str]]:
    """Return the cells of a table as text: numbers with four digits, and "" for NaN or None."""
    return table.map(as_text).to_numpy().tolist()
