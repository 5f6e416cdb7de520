"""Commands take the parameters of public functions, and their docstrings as help."""

import inspect

import pytest

import ringwear
from ringwear.studies.arguments import COMMANDS, FLAGS, REPEATED, Parser, add_arguments
from ringwear.studies.documented import documented
from ringwear.studies.named_studies import STUDIES

PUBLIC = [name for name in COMMANDS if name in ringwear.__all__]
PLACES = [
    *((each.place, f"commands:_{name}") for name, each in COMMANDS.items() if name != "study"),
    *((study.place, "commands:_study") for study in STUDIES.values()),
]


@pytest.mark.parametrize("name", PUBLIC)
def test_what_is_read_without_loading_is_what_is_loaded(name):
    function, read = getattr(ringwear, name), documented(COMMANDS[name].place)
    parameters = inspect.signature(inspect.unwrap(function)).parameters.values()
    named = [each for each in parameters if each.kind != each.VAR_KEYWORD]
    assert [*read.parameters] == [each.name for each in named]
    assert inspect.getdoc(function).startswith(f"{read.purpose}.")
    for each in named:
        parameter = read.parameters[each.name]
        assert bool(parameter.default) == (each.default is not each.empty)
        assert (parameter.default == "False") == (each.default is False)
        assert parameter.by_position == (each.kind != each.KEYWORD_ONLY)


@pytest.mark.parametrize(("place", "conduct"), PLACES)
def test_every_argument_of_a_command_has_a_text(place, conduct):
    assert documented(place or conduct).purpose
    parser = Parser(prog="command")
    add_arguments(parser, place or conduct, conduct)
    for action in parser._actions:
        assert action.help, action.dest


def test_every_flag_is_that_of_a_command():
    places = {place for pair in PLACES for place in pair}
    names = {name for place in places - {""} for name in documented(place).parameters}
    assert names >= FLAGS.keys() >= REPEATED.keys()


@pytest.mark.parametrize("name", STUDIES)
def test_every_option_of_a_study_has_a_text(name):
    row = STUDIES[name]
    assert row.purpose
    assert all(documented(row.place).parameters[option].text for option in row.options)
