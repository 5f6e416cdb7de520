"""Details of figures: labels of ticks, marks at borders, titles, and the times that are drawn."""

import pytest
from matplotlib.figure import Figure

from ringwear import Scene
from ringwear.studies.crosscheck.methods.inside.interior import first_and_last_in_contact
from ringwear.studies.refinement.case import Case
from ringwear.studies.study.errors_over_size import set_round_ticks
from ringwear.studies.tradeoff import draw


def labels_of(axis):
    return [text.get_text() for text in axis.get_ticklabels()]


@pytest.mark.parametrize(
    ("limits", "labels"),
    [
        ((1.2e-5, 7e-4), ["2·10⁻⁵", "5·10⁻⁵", "1·10⁻⁴", "2·10⁻⁴", "5·10⁻⁴"]),
        ((0.0012, 0.07), ["0.002", "0.005", "0.01", "0.02", "0.05"]),
        ((1e-9, 1e-1), ["10⁻⁹", "10⁻⁷", "10⁻⁵", "10⁻³", "10⁻¹"]),
    ],
)
def test_ticks_of_errors_are_plain_numbers_or_powers_of_ten(limits, labels):
    axes = Figure().subplots()
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=limits)
    set_round_ticks(axes)
    assert labels_of(axes.xaxis) == labels_of(axes.yaxis) == labels


def test_no_mark_of_the_challenge_is_cut_at_the_border():
    """Each mark has a radius of 1.5 points and a line of 0.4 points beyond it."""
    figure = Figure(figsize=(draw.PAGE, draw.HEIGHT), dpi=200)
    draw._draw_challenge(figure, 0)
    figure.draw_without_rendering()
    points = 0
    for axes in figure.axes:
        border = axes.bbox.padded(-2 * figure.dpi / 72)
        for line in axes.lines:
            for place in axes.transData.transform(line.get_xydata()):
                assert border.contains(*place), line
                points += 1
    assert points == len(draw.read_challenge())


@pytest.mark.parametrize(
    ("name", "changes", "title"),
    [
        ("five_rings", {}, "5 rings"),
        ("five_rings", {"punch.inner_radius": 0.1}, "hollow, 5 rings"),
        ("flat_punch", {"punch.inner_radius": 0.1}, "hollow, punch"),
        ("rotating_pin", {}, "wear along the radius"),
    ],
)
def test_figures_of_the_refinement_study_name_the_punch(name, changes, title):
    first, second = Case.all_of(Scene.load(name).changed(changes))
    assert (first.title, second.title) == ("flat punch", title)


def test_fields_are_shown_at_times_at_which_something_presses():
    """The brake presses from 0 on and until 14.5 s, at which its force is 0."""
    brake = Scene.load("duty_cycle")
    assert first_and_last_in_contact(brake) == [0.1, 14.25]
    assert first_and_last_in_contact(Scene.load("sphere").changed(wear__times=[1.0, 2.0])) == [0, 2]
    released = brake.changed(wear__times=[0.0, 5.0])
    # nothing presses at any of the times
    assert first_and_last_in_contact(released) == [0.0, 5.0]
