"""Where a method's own estimates fall short of the accuracy asked for, it is refined."""

import pytest

from ringwear import Scene, run

RTOL = 1e-6
# wear so even between these rings that the error of the indentation is nothing to roundoff
EVEN = {
    "methods": ["mdr"],
    "punch": {"radius": 1.0, "ring_edges": [0.05, 1.0], "wear_coefficients": [0.3, 1.0]},
    "half_space": {"plane_strain_modulus": 1.0},
    "load": {"normal_force": 1.0},
    "accuracy": {"rtol": RTOL},
}


@pytest.mark.parametrize("wear", [{"times": [20.0]}, {}], ids=["late", "steady state only"])
def test_fields_are_refined_where_the_indentation_has_no_error(wear):
    """The first once divided by an error of zero; of the second, fields stayed as they were."""
    solution = run(Scene.from_table(EVEN | {"wear": wear})).solutions["mdr"]
    assert solution.parts["discretisation"] <= 1e-9
    assert not solution.beyond(RTOL)
