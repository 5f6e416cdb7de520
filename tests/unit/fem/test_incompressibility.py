"""Poisson's ratio 1/2 in finite elements: the second solid of the extrapolation, and one text."""

from pathlib import Path

import pytest

from ringwear.fem.incompressibility import (
    HIGHEST_RATIO,
    confined_compliance,
    more_compressible_ratio,
)

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("nominal", [0.5, 0.499995, HIGHEST_RATIO])
def test_the_second_solid_is_twice_as_far_in_its_confined_compliance(nominal):
    second = more_compressible_ratio(HIGHEST_RATIO, nominal)
    compliances = [confined_compliance(ratio) for ratio in (nominal, HIGHEST_RATIO, second)]
    steps = compliances[1] - compliances[0], compliances[2] - compliances[1]
    assert steps[0] == pytest.approx(steps[1], abs=1e-15)
    assert second <= HIGHEST_RATIO + 1e-16


def test_a_confined_layer_has_its_oedometric_modulus():
    """M = E (1 - nu) / ((1 + nu) (1 - 2 nu)), from Hooke's law without lateral strain."""
    modulus, ratio = 3.0, 0.2
    oedometric = modulus * (1 - ratio) / ((1 + ratio) * (1 - 2 * ratio))
    shear = modulus / (2 * (1 + ratio))
    assert confined_compliance(ratio) == pytest.approx(2 * shear / oedometric, rel=1e-15)


@pytest.mark.parametrize("file", ["fem/README.md", "studies/crosscheck/verdict/README.md"])
def test_the_documentation_gives_the_ratio_that_is_modelled(file):
    text = (ROOT / file).read_text("utf-8")
    assert str(HIGHEST_RATIO).lstrip("0") in text
    assert "1/2 - 1e-8" not in text
    assert ".499999" not in text
