"""Write tables of studies in Markdown and LaTeX, for papers and notes."""

import re

import numpy as np
import pandas as pd

SPECIAL = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}
"""Characters that are commands in LaTeX, and the code that prints each of them."""
SYMBOLS = {
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
"""Symbols that plain LaTeX cannot read, and the code that prints each of them."""


MOST_COLUMNS = 5
"""Greatest number of columns that fit a page and a terminal."""


def blocks(table: pd.DataFrame) -> list[pd.DataFrame]:
    """Return a table as several of up to `MOST_COLUMNS` columns, each with the first column."""
    first, *others = table.columns
    return [
        table[[first, *others[start : start + MOST_COLUMNS - 1]]]
        for start in range(0, len(others), MOST_COLUMNS - 1)
    ]


def to_markdown(table: pd.DataFrame) -> str:
    """Return a table in the pipe syntax of Markdown, with aligned columns."""
    rows = [[str(name) for name in table.columns], *cells(table)]
    rows = [[_escape_pipes(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    rows.insert(1, ["-" * width for width in widths])
    return "".join(f"| {' | '.join(map(str.ljust, row, widths))} |\n" for row in rows)


def to_latex(table: pd.DataFrame) -> str:
    """Return a table as a `tabular` with the rules of the package `booktabs`."""
    header = " & ".join(escape_latex(str(name)) for name in table.columns)
    body = [" & ".join(map(escape_latex, row)) + r" \\" for row in cells(table)]
    alignment = "".join("r" if np.issubdtype(kind, np.number) else "l" for kind in _kinds(table))
    return "\n".join(
        [
            rf"\begin{{tabular}}{{{alignment}}}",
            r"\toprule",
            header + r" \\",
            r"\midrule",
            *body,
            r"\bottomrule",
            r"\end{tabular}",
            "",
        ]
    )


def cells(table: pd.DataFrame) -> list[list[str]]:
    """Return the cells of a table as text: numbers with four digits, and "" for NaN or None."""
    return [[_as_text(cell) for cell in row] for row in table.itertuples(index=False)]


def escape_latex(text: str) -> str:
    """Escape a text for LaTeX, except parts between dollar signs, which are formulas already."""
    parts = re.split(r"(\$[^$]+\$)", text)
    return "".join(
        part if number % 2 else "".join(SPECIAL.get(each, SYMBOLS.get(each, each)) for each in part)
        for number, part in enumerate(parts)
    )


def _kinds(table: pd.DataFrame) -> list[np.dtype]:
    """Return the numpy type of each column; columns of texts have the type object."""
    return [
        kind if isinstance(kind, np.dtype) else np.dtype(object) for kind in table.dtypes.tolist()
    ]


def _escape_pipes(cell: str) -> str:
    return cell.replace("|", r"\|")


def _as_text(cell: object) -> str:
    if cell is None or (isinstance(cell, float | np.floating) and np.isnan(cell)):
        return ""
    if isinstance(cell, float | np.floating):
        return f"{float(cell):.4g}"
    return str(cell).replace("\n", " ")
