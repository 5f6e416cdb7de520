"""Details of figures: the times that are drawn."""

from ringwear import Scene
from ringwear.studies.crosscheck.methods.inside.interior import first_and_last_in_contact


def test_fields_are_shown_at_times_at_which_something_presses():
    """The brake presses from 0 on and until 14.5 s, at which its force is 0."""
    brake = Scene.load("duty_cycle")
    assert first_and_last_in_contact(brake) == [0.1, 14.25]
    assert first_and_last_in_contact(Scene.load("sphere").changed(wear__times=[1.0, 2.0])) == [0, 2]
    released = brake.changed(wear__times=[0.0, 5.0])
    # nothing presses at any of the times
    assert first_and_last_in_contact(released) == [0.0, 5.0]
