"""Details of figures: labels of ticks, and the times that are drawn."""

import pytest

from ringwear import Scene
from ringwear.studies.crosscheck.methods.inside.interior import first_and_last_in_contact
from ringwear.studies.figures.ticks import short_number, spread


@pytest.mark.parametrize(
    ("limits", "labels"),
    [
        ((1.2e-5, 7e-4), ["10⁻⁴"]),
        ((1.2e-5, 7e-5), ["2·10⁻⁵", "5·10⁻⁵"]),
        ((0.0012, 0.07), ["0.002", "0.005", "0.01", "0.02", "0.05"]),
        ((0.12, 0.19), ["0.12", "0.13", "0.14", "0.15", "0.16", "0.17", "0.18", "0.19"]),
    ],
)
def test_ticks_of_short_axes_are_round_numbers(limits, labels):
    written = [short_number(value) for value in spread(*limits)]
    assert 2 <= len(written) <= 5
    if len(labels) > 1:
        assert set(written) <= set(labels)


def test_fields_are_shown_at_times_at_which_something_presses():
    """The brake presses from 0 on and until 14.5 s, at which its force is 0."""
    brake = Scene.load("duty_cycle")
    assert first_and_last_in_contact(brake) == [0.1, 14.25]
    assert first_and_last_in_contact(Scene.load("sphere").changed(wear__times=[1.0, 2.0])) == [0, 2]
    released = brake.changed(wear__times=[0.0, 5.0])
    # nothing presses at any of the times
    assert first_and_last_in_contact(released) == [0.0, 5.0]
