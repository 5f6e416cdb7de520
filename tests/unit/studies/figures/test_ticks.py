"""Ticks and labels of figures: round numbers, few, with up to three digits."""

import numpy as np
import pytest

from ringwear.studies.figures.style import (
    LOOKS,
    axis_start,
    looks_of,
    new_panels,
    rings_differ,
    set_linear,
    set_logarithmic,
    show_values,
)
from ringwear.studies.figures.ticks import power_of_ten, short_number


@pytest.fixture
def axes():
    _, panels = new_panels(4, 3)
    return panels[0, 0]


def labelled(axis):
    """Return the label of each tick within an axis; those that need too many digits have none."""
    low, high = axis.get_view_interval()
    form = axis.get_major_formatter()
    ticks = [tick for tick in axis.get_major_locator()() if low <= tick <= high]
    return {tick: form(tick, None) for tick in ticks if form(tick, None)}


@pytest.mark.parametrize("most", [3, 4, 6])
@pytest.mark.parametrize(
    "ends", [(0.0, 1.0), (0.0, 12.0), (-0.06, 1.08), (18.0, 25.0), (20.5, 26.8), (-4.9, 4.9)]
)
def test_linear_axes_have_few_round_labels(axes, ends, most):
    axes.set_xlim(ends)
    set_linear(axes, "x", most)
    labels = labelled(axes.xaxis)
    assert 2 <= len(labels) <= most + 1 or most == 3
    for tick, label in labels.items():
        assert float(label.replace("−", "-")) == pytest.approx(tick, abs=1e-12)
        mantissa = f"{abs(tick):.6e}".rstrip("0").partition("e")[0].rstrip("0")
        assert len(mantissa.replace(".", "")) <= 2


@pytest.mark.parametrize("value", [1.0, 9.99e-7, 0.0314159, 99.7, 6.2475e8, -1.2345])
@pytest.mark.parametrize("change", [0.0, 1e-12, 1e-5, 0.003, 0.2, 3.0])
def test_values_that_hardly_change_span_one_percent_with_two_labels_of_three_digits(
    axes, value, change
):
    axes.plot([0, 1], [value, value * (1 + change)])
    show_values(axes)
    low, high = axes.get_ylim()
    assert high - low >= 0.00999 * abs(value)
    assert low <= min(value, value * (1 + change)) <= max(value, value * (1 + change)) <= high
    labels = labelled(axes.yaxis)
    assert len(set(labels.values())) == len(labels) >= 2
    # a label is the tick itself, not rounded to another number
    for tick, label in labels.items():
        mantissa, _, exponent = label.replace("−", "-").partition("·10")
        plain = exponent.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
        assert float(mantissa) * 10.0 ** int(plain or 0) == pytest.approx(tick, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(
    ("low", "high"),
    [
        *((1e-9, 1e2), (0.5e-3, 2.0), (0.15, 6.0), (1.2e-5, 7e-4), (1.2e-5, 7e-5), (0.0012, 0.07)),
        *((0.12, 0.19), (8e-6, 1.9e-5), (0.995, 1.3), (3.1, 3.6)),
    ],
)
def test_logarithmic_axes_have_two_labels_or_more(axes, low, high):
    axes.set_xlim(low, high)
    set_logarithmic(axes, "x")
    axes.set_xlim(low, high)
    labels = labelled(axes.xaxis).values()
    assert 2 <= len(set(labels)) == len(labels) <= 6
    if high >= 100 * low:
        assert all(label.startswith("10") for label in labels)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (0.25, "0.25"),
        (-1.5, "−1.5"),
        (12000.0, "12000"),
        (1.9e3, "1900"),
        (2e-5, "2·10⁻⁵"),
        (6.2475e8, "6.25·10⁸"),
        (0.30000000000000004, "0.3"),
    ],
)
def test_numbers_are_short(value, text):
    assert short_number(value) == text


def test_powers_of_ten_are_written_as_such():
    assert [power_of_ten(value) for value in (1e-3, 1.0, 0.2)] == ["10⁻³", "10⁰", "2·10⁻¹"]


def test_a_method_has_one_look_whatever_else_is_drawn():
    alone = looks_of(["mdr", "mine"])
    beside = looks_of(["fem", "mine", "direct", "ansys", "abaqus"], ["ansys", "abaqus"])
    assert alone["mine"] == beside["mine"]
    # looks do not depend on earlier calls
    assert looks_of(["yours"])["yours"] == alone["mine"]
    assert looks_of(["mine", "yours"])["mine"] == alone["mine"]
    for name, look in LOOKS.items():
        assert beside[name] == alone[name] == look
    names = ["mdr", "fem", "bem", "direct", "mdr-grid", "mine", "ansys", "abaqus"]
    assert len({beside[name]["color"] for name in names}) == len(names)


def test_rings_of_similar_wear_are_not_distinguished():
    assert not rings_differ(np.array([2.127e-5, 2.107e-5]))
    assert not rings_differ(np.array([1.0]))
    assert rings_differ(np.array([1.0, 1.5]))


def test_a_wide_hole_is_not_drawn():
    assert axis_start(0.0, 10.0) == axis_start(4.0, 10.0) == 0.0
    assert 17 < axis_start(18.0, 25.0) < 18
