"""All factors of error estimates are in one table that code, documentation and tests share."""

import re
from pathlib import Path

import pytest

from ringwear.studies.crosscheck.methods.error_factors import TABLE

ROOT = Path(__file__).parents[5]


def test_the_documentation_shows_the_table():
    lines = ["| name | value | multiplies | shown by |", "| --- | --- | --- | --- |"]
    for name, factor in TABLE.items():
        test = factor.shown_by.removeprefix("tests/")
        lines.append(f"| {name} | {factor.value:g} | {factor.multiplies} | `{test}` |")
    page = ROOT / "studies" / "crosscheck" / "verdict" / "README.md"
    assert "\n".join(lines) in page.read_text("utf-8")


@pytest.mark.parametrize("name", TABLE)
def test_a_factor_is_used_and_shown_by_a_test_that_exists(name):
    code = "".join(file.read_text("utf-8") for file in (ROOT / "studies").rglob("*.py"))
    assert code.count(f'"{name}"') >= 2
    file, test = TABLE[name].shown_by.split("::")
    assert re.search(rf"^def {test}\(", (ROOT / file).read_text("utf-8"), re.MULTILINE)


def test_evaluations_have_no_other_factors():
    for name in ("evaluation", "moving_evaluation", "fem"):
        text = (ROOT / "studies" / "crosscheck" / "methods" / f"{name}.py").read_text("utf-8")
        assert not re.search(r"safety\w* = [\d.]+$", text, re.MULTILINE)
