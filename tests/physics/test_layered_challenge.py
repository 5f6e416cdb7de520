"""Answers of the challenge on layered ground, against limits and independent solutions."""

import ball_on_pad
import numpy as np
import pandas as pd
import pytest
from independent import CONSTANT, Pieces, Punch
from independent_layer import kernel, start
from layered_disc import Layer, fields_under_uniform_pressure, wave_numbers
from scipy.linalg import cholesky
from scipy.special import j0

from ringwear import Scene, run
from ringwear.studies.challenge.answers import read_answers
from ringwear.studies.challenge.problems import SCENE, number_of, problems

PROBLEMS = {number_of(path): path for path in problems() if path.name == SCENE}
ANSWERS = {number: read_answers(path) for number, path in PROBLEMS.items()}


@pytest.mark.parametrize("poisson_ratio", ANSWERS[13]["poisson_ratio"].unique())
def test_bonded_layers_against_an_independent_solution(poisson_ratio):
    answers = ANSWERS[13]
    for row in answers[answers["poisson_ratio"] == poisson_ratio].itertuples():
        exact = 0.5 / start(1 / row.radius_over_thickness, row.poisson_ratio)
        assert float(row.value) == pytest.approx(exact, rel=row.bound)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.45, 0.5])
def test_the_ball_by_the_equation_of_fredholm(poisson_ratio):
    thickness = Scene.load(PROBLEMS[14]).half_space.layers[0].thickness
    ball = ball_on_pad.Ball(10.0, thickness, poisson_ratio)
    answers = ANSWERS[14].query("poisson_ratio == @poisson_ratio")
    for force, rows in answers.groupby("normal_force"):
        pressed = ball_on_pad.pressed_by(ball, force, 0.01)._asdict()
        for row in rows.itertuples():
            assert float(row.value) == pytest.approx(pressed[row.quantity], rel=row.bound, abs=0)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.5])
def test_the_ball_by_boundary_elements(poisson_ratio):
    pad = {"youngs_modulus": 1 - poisson_ratio**2, "poisson_ratio": poisson_ratio}
    scene = Scene.load(PROBLEMS[14])
    pad["thickness"] = scene.half_space.layers[0].thickness
    dataset = run(scene.changed(half_space__layers=[pad]), methods=["bem"], rtol=1e-4).dataset
    rows = ANSWERS[14].set_index(["normal_force", "poisson_ratio", "quantity"])["value"]
    for quantity in ("indentation", "contact_radius"):
        answer = float(rows[1e-2, poisson_ratio, quantity])
        assert float(dataset[quantity][0, 0]) == pytest.approx(answer, rel=1e-7)


def test_the_road_by_the_transform_of_hankel():
    radius, pressure = 5.99, 100.0
    road = ((6, 5e5, 0.35), (10, 4e4, 0.4), (np.inf, 1e4, 0.45))
    layers = [Layer(thickness / radius, *material) for thickness, *material in road]
    for (depth, number), rows in ANSWERS[15].groupby(["depth", "layer"]):
        fields = fields_under_uniform_pressure(
            layers, number - 1, np.zeros(1), np.array([depth / radius])
        )
        ((_, displacement),), ((radial, axial, _, _),) = fields
        exact = {"displacement": displacement * radius, "stress_zz": axial, "stress_rr": radial}
        for row in rows.itertuples():
            value = exact[row.quantity] * pressure
            assert float(row.value) == pytest.approx(value, rel=row.bound)


def test_the_deflection_of_the_road_by_dimensionality_reduction():
    dataset = run(Scene.load(PROBLEMS[15]), methods=["mdr"], rtol=1e-8).dataset
    rows = ANSWERS[15].set_index(["depth", "layer", "quantity"])
    answer = rows.loc[(0.0, 1, "displacement")]
    deflection = float(dataset["steady_displacement_max"][0])
    assert float(answer["value"]) == pytest.approx(deflection, rel=answer["bound"])


class OnPad(Punch):
    """The independent history of `independent`, with the layer's compliance added."""

    def __init__(self, thickness, poisson_ratio, *punch):
        self.pad = thickness, poisson_ratio
        super().__init__(*punch)

    def _triangular_energy(self):
        half_space = super()._triangular_energy()
        thickness, poisson_ratio = self.pad
        s, lengths = wave_numbers(thickness, 2.0)
        bessel = j0(np.outer(self.radius, s)) * self.length[:, None] / 2
        transforms = self.orthonormal(self.values.T @ bessel)
        weights = 4 * np.pi * lengths * (kernel(s * thickness, poisson_ratio) - 1)
        return cholesky(half_space.T @ half_space + (transforms * weights) @ transforms.T)


def test_rings_on_the_pad_against_an_independent_solution():
    answers = ANSWERS[16].astype({"value": float})
    wear, force = np.array([1.0, 10.0, 1.0, 10.0, 1.0]), 2.0
    pieces = Pieces(np.linspace(0, 1, 6), wear, wear)
    punch = OnPad(0.1, 0.3, pieces, np.append(np.inf, np.full(5, 1e-6)), 16)
    (slowest,) = answers[answers["quantity"] == "relaxation_time"]["value"]
    assert slowest == pytest.approx(punch.times[0], rel=1e-9)
    later = answers[answers["time"] > 0]
    times, radii = later["time"].unique(), later["radius"].dropna().unique()
    pressures = punch.pressures(CONSTANT, times)
    indentation = punch.depths(CONSTANT, times, pressures)
    of_pressures, of_heights, _ = punch.fields(radii)
    fields = {
        "pressure": pressures @ of_pressures.T,
        "profile": punch.worn(indentation, pressures) @ of_heights.T,
    }
    assert table_of(later, "indentation").ravel() == pytest.approx(force * indentation, rel=1e-9)
    for quantity, values in fields.items():
        assert table_of(later, quantity) == pytest.approx(force * values, rel=2e-8)


def table_of(answers, quantity):
    """Return the values of a quantity, with a row for each time and a column for each radius."""
    rows = answers[answers["quantity"] == quantity]
    return pd.pivot_table(rows.fillna(0.0), "value", "time", "radius", sort=True).to_numpy()
