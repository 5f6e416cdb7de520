"""Tables in Markdown, LaTeX and CSV keep all cells, and special characters are escaped."""

import numpy as np
import pandas as pd

from ringwear.studies.study.formats import to_latex, to_markdown
from ringwear.studies.tables.writing import write_csv

TABLE = pd.DataFrame(
    {
        "method": ["mdr", "fem | quads", "50 % of d_0 & more"],
        "error ν=0.3": [1.23456e-7, np.nan, 2.0],
        "n": [1, 20, 300],
        "label": ["$d_0$", "a\nb", "x^2 ~ #1 {y} \\z"],
    }
)


def test_a_markdown_table_has_the_same_cells():
    head, rule, *rows = to_markdown(TABLE).splitlines()
    assert [cell.strip() for cell in head.split("|")[1:-1]] == list(TABLE)
    assert {*rule} == {*"|- "}
    cells = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]
    assert [row[0] for row in cells] == ["mdr", r"fem \| quads", "50 % of d_0 & more"]
    assert [row[1] for row in cells] == ["1.235e-07", "", "2"]
    assert cells[1][3] == "a b"


def test_all_rows_of_a_latex_table_have_the_same_number_of_cells():
    lines = to_latex(TABLE).splitlines()
    rows = [line for line in lines if line.endswith(r"\\")]
    assert len(rows) == 4
    for row in rows:
        assert row.replace(r"\&", "").count("&") == 3
    assert lines[0] == r"\begin{tabular}{lrrl}"


def test_special_characters_of_latex_are_escaped_except_in_formulas():
    table = pd.DataFrame({"≤ & $x_1$": ["50 % of $d_0$ & a_b, ν", "\\z"]})
    _, _, head, _, *rows, _, _ = to_latex(table).splitlines()
    assert head == r"$\le$ \& $x_1$ \\"
    assert rows == [r"50 \% of $d_0$ \& a\_b, $\nu$ \\", r"\textbackslash z \\"]


def test_cells_of_csv_are_not_formulas(tmp_path):
    """Texts that a spreadsheet would compute are marked as texts; numbers stay numbers."""
    texts = ["=1+1", "+A1", "-cmd", "@SUM(1)", "\t=1", "plain", "-1.5"]
    table = pd.DataFrame({"=title": texts, "number": np.linspace(-1.0, 1.0, len(texts))})
    write_csv(table, tmp_path / "table.csv")
    head, *rows = (tmp_path / "table.csv").read_text().splitlines()
    assert head == "'=title,number"
    assert [row.rpartition(",")[0] for row in rows] == [
        *(f"'{text}" for text in texts[:5]),
        *texts[5:],
    ]
    assert [float(row.rpartition(",")[2]) for row in rows] == table["number"].tolist()
