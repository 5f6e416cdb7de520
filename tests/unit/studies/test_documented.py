"""Commands take the parameters of public functions, and their docstrings as help."""

import inspect

import pytest

import ringwear
from ringwear.studies.arguments import FLAGS, OF_COMMANDS, POSITIONAL, flag_of
from ringwear.studies.commands import COMMANDS
from ringwear.studies.documented import documented
from ringwear.studies.named_studies import STUDIES

PUBLIC = [name for name in COMMANDS if name in ringwear.__all__]


@pytest.mark.parametrize("name", PUBLIC)
def test_what_is_read_without_loading_is_what_is_loaded(name):
    function, read = getattr(ringwear, name), documented(COMMANDS[name].place)
    parameters = inspect.signature(inspect.unwrap(function)).parameters.values()
    named = [each for each in parameters if each.kind != each.VAR_KEYWORD]
    assert [*read.parameters] == [each.name for each in named]
    assert inspect.getdoc(function).startswith(f"{read.purpose}.")
    for each in named:
        default = read.parameters[each.name].default
        assert default is None or default == each.default


@pytest.mark.parametrize("name", COMMANDS)
def test_every_argument_of_a_command_has_one_meaning_and_a_text(name):
    read = documented(COMMANDS[name].place)
    assert read.purpose
    for argument in COMMANDS[name].arguments:
        if argument not in OF_COMMANDS and argument not in POSITIONAL:
            assert flag_of(argument) in FLAGS
            assert read.parameters[argument].text


@pytest.mark.parametrize("name", STUDIES)
def test_every_option_of_a_study_has_a_text(name):
    row = STUDIES[name]
    assert row.purpose
    assert all(documented(row.place).parameters[option].text for option in row.options)
