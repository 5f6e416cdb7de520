"""Every number of the answer has an estimate that bounds its error, whatever the output times."""

from itertools import pairwise

import numpy as np
import pytest
from independent import solved
from natural import natural

from ringwear import direct, run


@pytest.mark.parametrize("times", [[0.0, 1e-3, 1.0], [5.0], [1e3]])
@pytest.mark.gmsh
def test_every_number_of_the_answer_has_an_estimate_that_bounds_its_error(times):
    """Errors against closed forms are below the estimates, and all numbers have an estimate."""
    edges, wear = np.arange(6) / 5, np.array([1.0, 10.0, 1.0, 10.0, 1.0])
    result = run(natural({"rings": 5, "wear_coefficients": [1.0, 10.0]}, times, 1e-4))
    assert result.verdict == "agree"
    pressures = direct.steady_pressures(edges, wear)
    root = np.sqrt(1 - edges**2)
    exact = {
        "indentation_start": 0.5,
        "indentation_steady": direct.greatest_displacement(edges, pressures),
        "steady_wear_rate": wear[0] * pressures[0],
        "steady_rms_slope": direct.rms_slope(edges, pressures),
        "force_share": np.array([-np.diff(root), np.pi * np.diff(edges**2) * pressures]),
    }
    for answer in result.answers.values():
        numbers = {name for name in answer if not name.endswith("_error")}
        assert {f"{name}_error" for name in numbers} <= answer.keys()
        for name, value in exact.items():
            error = np.abs(answer[name] - value).max() / (1.0 if "share" in name else value)
            assert error <= np.max(answer[f"{name}_error"]) <= 1e-4, name
        # sum of V / k over the rings = F v0 t
        worn = np.sum(answer["worn_volume"] / wear)
        assert worn == pytest.approx(times[-1], rel=1e-9)


def test_steps_of_a_table_need_not_be_ring_edges():
    """Such a table gives the results of rings; once the steady states disagreed."""
    table = {"radii": [0.0, 0.5, 0.5, 1.0], "values": [1.0, 1.0, 5.0, 5.0]}
    one, two = (
        run(natural(punch, [0.0, 0.1, 1.0], 1e-4, "mdr bem"))
        for punch in (
            {"wear_coefficient": table},
            {"ring_edges": [0.5, 1.0], "wear_coefficients": [1.0, 5.0]},
        )
    )
    assert one.verdict == two.verdict == "agree"
    np.testing.assert_allclose(one.dataset.indentation, two.dataset.indentation, rtol=1e-7)


def test_weak_kinks_of_a_table_get_no_layers():
    """Very weak kinks get no layers of small elements; once, 300 points took 5,000 pressures."""
    radii = np.linspace(0, 1, 300)
    table = {"radii": radii.tolist(), "values": (1 + np.sin(7 * radii) ** 2).tolist()}
    scene = natural({"wear_coefficient": table}, [0.0, 0.01, 1.0], 1e-4, "mdr")
    edges = scene.problem.merged.kinks
    assert (edges[:-1] < 0.1).all()
    few = natural(
        {"wear_coefficient": {"radii": radii[::23].tolist(), "values": table["values"][::23]}},
        [0.0, 1.0],
        1e-4,
        "mdr",
    )
    assert any(kink > 0.1 for kink in few.problem.merged.kinks[:-1])
    assert all(a < b for a, b in pairwise(scene.problem.merged.ring_edges))


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("quantities", [["rms_slope"], ["rms_slope", "indentation"], ["history"]])
def test_slopes_of_hardly_worn_rings_do_not_depend_on_what_is_asked(quantities):
    """Modes whose relaxation times are near roundoff made slopes up to three times too large."""
    rings = {"rings": 3, "wear_coefficients": [1.0, 1e-10]}
    methods = "mdr" if "history" in quantities else "mdr fem"
    given = natural(rings, [0.01, 1.0], 1e-3, methods, output={"quantities": quantities})
    exact, _, _ = solved(given.problem, 1e-3)
    for solution in run(given).solutions.values():
        wrong = np.abs(solution.compared["rms_slope"] / exact["rms_slope"] - 1)
        assert (wrong <= 1e-3).all()
        assert (solution.errors["rms_slope"] <= 1e-3).all()
