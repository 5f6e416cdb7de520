"""The READMEs of the challenge contain the generated tables."""

from ringwear.studies.challenge.problems import FOLDER, OTHERS, problem_named, problems
from ringwear.studies.challenge.rows import errors_table, problems_table


def test_the_readmes_have_the_generated_tables():
    for folder, table in ((FOLDER, problems_table()), (OTHERS, errors_table())):
        assert "\n".join(table) in (folder / "README.md").read_text("utf-8")


def test_problems_have_names_and_numbers():
    assert len(problems()) == 12
    for name in ("03_five_rings", "five_rings", "3", "03"):
        assert problem_named(name).name == "03_five_rings.toml"
