"""`ringwear compare` on two results, and results as CSV."""

import numpy as np
import pandas as pd
import pytest
import xarray

from ringwear import Scene, compare, load, main, run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("rubber")
    flags = ["--methods", "direct,mdr", "--rtol", "1e-3", "--csv", "--no-figures"]
    assert main(["run", "rubber", *flags, "--out", str(out)]) == 0
    return out


@pytest.mark.slow
def test_compare_lists_the_differences(folder, command, tmp_path):
    out = tmp_path / "out"
    scene = Scene.load("rubber").changed(methods=["mdr", "direct"], load__mean_pressure=6e5)
    output = command(f"compare {folder} scene.toml --out out", scene=scene).out
    # every number is proportional to the load or independent of it
    change = pd.read_csv(out / "answers.csv", index_col=0)["B against A"]
    for name in ("steady_wear_rate", "indentation_steady", "steady_rms_slope"):
        assert change[name] == "+100 %"
        assert name in output
    assert abs(float(change["running_in_time"].removesuffix(" %"))) < 1e-3
    keys = pd.read_csv(out / "scenes.csv", index_col=0)
    assert keys.loc["load.mean_pressure"].tolist() == ["300000.0", "600000.0"]
    assert "punch.radius" not in keys.index
    assert (out / "comparison.png").exists()
    assert (out / "difference.png").exists()


def test_twice_the_load_differs_by_the_result_itself_at_the_start(folder):
    twice = run(Scene.load("rubber").changed(methods=["mdr"], load__mean_pressure=6e5))
    comparison = compare(load(folder), twice).fields
    fields = {field.quantity: field for field in comparison.fields}
    # at the start everything is linear in the load, and the displacement is d everywhere
    start = fields["displacement"].relative[0]
    np.testing.assert_allclose(start, 1.0, rtol=1e-3)
    assert fields["pressure"].norms[0] == pytest.approx(1.0, rel=1e-3)
    assert not fields["profile"].relative[0].any()
    assert not comparison.interpolated


def test_a_comparison_shows_and_saves_itself(folder, tmp_path):
    comparison = compare(load(folder), load(folder))
    for text in (repr(comparison), comparison._repr_html_()):
        assert "A and B are equal in" in text
        assert "steady_wear_rate" in text
    assert {"answers.csv", "difference.png"} <= {*comparison.save(tmp_path / "saved")}


def test_without_common_times_no_difference_is_drawn(folder, command, tmp_path):
    scene = Scene.load("rubber").changed(
        methods=["mdr"], wear__times=[2e3, 2e4], wear__steady=False
    )
    output = command(f"compare {folder} scene.toml --out out", scene=scene).out
    assert "difference.png is not drawn: no field is given by both" in output
    assert {file.name for file in (tmp_path / "out").glob("[!.]*")} == {
        "scenes.csv",
        "answers.csv",
        "comparison.png",
    }


def test_results_in_other_units_are_refused(folder, command, tmp_path):
    scene = Scene.load("flat_punch").changed(methods=["direct"])
    assert "units" in command(f"compare {folder} scene.toml --out out", 2, scene).err
    assert not (tmp_path / "out").exists()


def test_csv_tables_have_the_numbers_of_results_nc(folder):
    tables = {file.stem: pd.read_csv(file) for file in folder.glob("*.csv")}
    results = xarray.load_dataset(folder / "results.nc")
    over_time = {"solver_time", "solver_time_radius", "solver_time_ring", "solver_time_edge"}
    others = {"solver", "solver_ring", "solver_radius", "solver_mode", "solver_state_ring"}
    others.add("solver_state")  # errors of the numbers of each ring
    assert set(tables) == over_time | others
    fields = tables["solver_time_radius"]
    assert len(fields) == results.sizes["time"] * results.sizes["radius"]
    last, pressure = fields.iloc[-1], results.pressure.sel(solver="mdr")[-1, -1]
    assert last[["solver", "time [s]", "pressure [Pa]"]].tolist() == ["mdr", 3e6, float(pressure)]
    # direct integration has no history, so it has no row
    assert set(tables["solver_time"]["solver"]) == {"mdr"}
    assert set(tables["solver"]["solver"]) == {"mdr", "direct"}
    edges = tables["solver_state_ring"]["ring_outer_radius [m]"][:5]
    assert edges.tolist() == Scene.load("rubber").punch.ring_edges
