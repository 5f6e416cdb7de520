"""Flat punches with slightly rounded edges, under realistic loads."""

from itertools import product

import pytest
from closed_forms import RoundedPunch
from groups import nightly
from natural import natural

from ringwear import run

# radius and mean pressure of usual punches that are solved quickly
QUICK = [(0.01, 1e-4), (0.03, 1e-3)]
OTHERS = {*product((0.003, 0.01, 0.03, 0.1), (1e-5, 1e-4, 1e-3))} - {*QUICK}


def rounded(radius, mean_pressure):
    """Return a punch whose edge is rounded over a width of twice the radius of the rounding."""
    profile = {"kind": "rounded_rim", "flat_radius": 1 - 2 * radius, "curvature_radius": radius}
    return natural(
        {"wear_coefficient": 1.0, "profile": profile},
        load={"mean_pressure": mean_pressure},
        wear={"times": [0.0, 0.1, 1.0], "steady": False},
    )


# without gmsh, the start of finite elements is as accurate as the march
@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(("radius", "mean_pressure"), [*QUICK, *nightly(*sorted(OTHERS))])
def test_lightly_rounded_edges(radius, mean_pressure):
    exact, scene = RoundedPunch(1 - 2 * radius, radius), rounded(radius, mean_pressure)
    contact = exact.contact_radius(scene.problem.units.force)
    result = run(scene)
    assert result.verdict == "agree"
    for solver in scene.methods:
        start = result.dataset.sel(solver=solver).isel(time=0)
        # rtol is 1e-3, but the start on a fitted mesh is far more accurate
        assert float(start.indentation) == pytest.approx(exact.indentation(contact), rel=1e-6)
        assert float(start.contact_radius) == pytest.approx(contact, rel=1e-6)
        assert not any("the start cannot be fitted" in note for note in result.notes)
