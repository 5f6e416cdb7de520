"""Two results beside each other, and results as CSV."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
import xarray

from ringwear import Scene
from ringwear.studies.cli import main


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("one")
    assert (
        main(
            [
                "run",
                "rubber",
                "--methods",
                "direct,mdr",
                "--rtol",
                "1e-3",
                "--csv",
                "--no-figures",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    return out


def test_compare_tells_what_differs(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.toml"
    scene = Scene.load("rubber").changed(
        methods=["mdr", "direct"], load__mean_pressure=6e5, title="Twice the load"
    )
    other.write_text(scene.to_toml(), "utf-8")
    assert main(["compare", str(folder), str(other), "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out
    # everything is linear in the load, but for what does not depend on it
    for name in ("steady_wear_rate", "indentation_steady", "steady_rms_slope", "indentation_start"):
        (line,) = [line for line in told.splitlines() if line.split()[:1] == [name]]
        assert line.split()[-2:] == ["+100", "%"]
    (line,) = [line for line in told.splitlines() if line.split()[:1] == ["running_in_time"]]
    assert abs(float(line.split()[-2])) < 1e-3
    (line,) = [line for line in told.splitlines() if "load.mean_pressure" in line]
    assert line.split()[1:] == ["300000.0", "600000.0"]
    assert "punch.radius" not in told
    assert {file.name for file in (tmp_path / "out").glob("*")} >= {
        "comparison.png",
        "answers.csv",
        "scenes.csv",
    }


@pytest.mark.parametrize(
    ("other", "told"),
    [
        ("five_rings", "units"),
        ("no_such_scene", "no such file"),
        ("EMPTY", "results.nc"),
        ("BROKEN", "cannot be read"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    other: str, told: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "EMPTY").mkdir()
    (tmp_path / "BROKEN").mkdir()
    (tmp_path / "BROKEN" / "results.nc").write_text("not netCDF", "utf-8")
    name = str(tmp_path / other) if other.isupper() else other
    assert main(["compare", str(folder), name, "--out", str(tmp_path / "out")]) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_csv_tables_are_the_results(folder: Path) -> None:
    tables = {
        file.stem: list(csv.DictReader(file.open(encoding="utf-8")))
        for file in folder.glob("*.csv")
    }
    with xarray.open_dataset(folder / "results.nc") as results:
        known = results.load()
    assert set(tables) == {
        "punch",
        "over_time",
        "over_time_and_radius",
        "ring_forces",
        "steady_over_radius",
        "worn_volumes",
        "rings",
        "relaxation_times",
    }
    assert len(tables["over_time_and_radius"]) == known.sizes["time"] * known.sizes["radius"]
    row = tables["over_time_and_radius"][-1]
    assert row["solver"] == "mdr"
    assert float(row["pressure [Pa]"]) == float(known.pressure.sel(solver="mdr")[-1, -1])
    assert float(row["time [s]"]) == 3e6
    # of direct integration there is no history, and no row
    assert {row["solver"] for row in tables["over_time"]} == {"mdr"}
    assert {row["solver"] for row in tables["punch"]} == {"mdr", "direct"}
    assert [float(row["ring_outer_radius [m]"]) for row in tables["rings"][:5]] == Scene.load(
        "rubber"
    ).punch.ring_edges
