"""Mistakes are tried in tables with any columns, and those without a solution are left out."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from ringwear import Scene, SolverError
from ringwear.studies.estimate.compared import PRINTED, Comparison
from ringwear.studies.estimate.diagnose import model_of
from ringwear.studies.estimate.histories import Strips
from ringwear.studies.estimate.mistakes import mistakes
from ringwear.studies.estimate.select import select

TIMES = np.array([0.0, 0.1, 0.5])
FLAT = Scene(
    punch={"radius": 1.0, "rings": 2, "wear_coefficients": [0.1, 1.0]},
    half_space={"plane_strain_modulus": 1.0},
    load={"normal_force": 2.0, "sliding_speed": 1.0},
    wear={"times": TIMES.tolist()},
)
BALL = FLAT.changed(punch__profile={"kind": "parabola", "curvature_radius": 5.0})


def compared(scene, names):
    """Return a comparison of columns whose values are 1, and half of ours."""
    radii = np.array([0.0, 0.3, 0.7, 1.0])
    shapes = {name: (len(TIMES),) for name in ("indentation", "normal_force")}
    theirs = {name: np.ones(shapes.get(name, (len(TIMES), len(radii)))) for name in names}
    ours = {name: 2 * values for name, values in theirs.items()}
    has_fields = bool(set(names) - set(shapes))
    return Comparison(TIMES, radii if has_fields else np.empty(0), theirs, ours, scene)


def predictions(model, comparison):
    """Return the name of each mistake, whether it changes the scene, and what it causes."""
    model, rows = model.for_measurements(comparison.measurements(0.02, 0.02)), []
    for mistake in mistakes(comparison):
        starts = zip(mistake.parameters, mistake.starts[-1], strict=True)
        # numbers that are fitted are between nodes
        x = np.array([each.coordinate(value) + 0.2 * (not each.values) for each, value in starts])
        values = model.with_parameters(mistake.parameters).predict(x)
        by_column = dict(zip(comparison.quantities, values, strict=True))
        rows.append((mistake.name, mistake.parameters[0].of_scene, by_column))
    return rows


@pytest.mark.slow
@pytest.mark.parametrize("scene", [FLAT, BALL], ids=["flat", "ball"])
def test_a_mistake_has_the_same_effect_on_a_column_in_every_table(scene):
    table = compared(scene, PRINTED)
    model = replace(model_of(table), known=())
    by_all = [row for row in predictions(model, table) if row[1]]
    assert len(by_all) > 2
    subsets = [
        names for size in range(1, len(PRINTED) + 1) for names in combinations(PRINTED, size)
    ]
    for names in subsets:
        rows = predictions(model, compared(scene, names))
        for name, _, values in rows:
            assert all(np.isfinite(each).all() for each in values.values()), (names, name)
        of_scene = [row for row in rows if row[1]]
        for (name, _, values), (other, _, expected) in zip(of_scene, by_all, strict=True):
            assert name == other
            for column in names:
                np.testing.assert_allclose(values[column], expected[column], rtol=1e-9)


def test_a_layer_is_interpolated_as_well_where_contact_is_lost():
    """Between a flat history and a march, as between two flat ones."""
    table = compared(FLAT, ["indentation"])
    (layer,) = (each for each in mistakes(table) if each.name == "layer")
    model = model_of(table).with_parameters(layer.parameters)
    # thickness and modulus of a layer that loses contact at one of the four nodes around it
    x = np.array([1.05, 2.5])
    assert len({type(each.history) for each in model._histories(x)}) == 2
    (interpolated,), (solved,) = model.predict(x), model.solved_directly().predict(x)
    np.testing.assert_allclose(interpolated, solved, rtol=0.05)


def tried():
    """Return the candidates for a load, and for a strip in plane strain."""
    table = compared(FLAT, ["indentation", "normal_force"])
    rows = [each for each in mistakes(table) if each.name in ("normal force", "plane strain")]
    found = select(model_of(table), rows)
    return {each.mistake.name for each in found if each.mistake is not None}


@pytest.mark.parametrize("error", [SolverError("singular"), np.linalg.LinAlgError("singular")])
def test_a_mistake_without_a_solution_is_left_out_with_a_word(error, monkeypatch, caplog):
    assert "plane strain" in tried()

    def fail(*_):
        raise error

    monkeypatch.setattr(Strips, "sample", fail)
    assert tried() == {"normal force"}
    assert "not tried as a mistake: plane strain: singular" in caplog.text


def test_a_programming_error_ends_the_search(monkeypatch):
    monkeypatch.setattr(Strips, "sample", lambda *_: {})
    with pytest.raises(KeyError):
        tried()
