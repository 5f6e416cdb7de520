"""The wear challenge from the command line: problems and submissions."""

import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from ringwear import Scene, main
from ringwear.studies.challenge.problems import layered_problems, name_of

HEAD = "| problem | program | quantity | values | greatest relative error | case |"


def printed(capsys):
    """Return the printed lines, without the spaces that align columns."""
    return re.sub(" +", " ", capsys.readouterr().out).splitlines()


def test_a_submission_to_the_challenge(tmp_path, capsys):
    radii = np.array([0.1, 0.5, 0.9])
    pressure = 1.01 / (np.pi * np.sqrt(1 - radii**2))
    rows = [f"0,{r},{p},0.98" for r, p in zip(radii, pressure, strict=True)]
    lines = ["# 1.5 s", "time,radius,pressure,indentation", *rows]
    (tmp_path / "01_mine.csv").write_text("\n".join(lines), "utf-8")
    assert main(["challenge", str(tmp_path / "01_mine.csv")]) == 0
    row = printed(capsys)[-1]
    assert row == "| 1 | 01_mine | 2.0e-2 | 1.0e-2 | 1.5 |"
    assert main(["challenge", "17", str(tmp_path / "01_mine.csv")]) == 2


def test_problems_are_listed_and_printed(capsys):
    assert main(["challenge"]) == 0
    listed = capsys.readouterr().out
    assert listed.count("\n") == 16
    assert main(["challenge", "--list"]) == 0
    assert capsys.readouterr().out == listed
    assert main(["challenge", "--list", "flat_punch"]) == 2
    for name, number in (("flat_punch", 1), ("13", 13), ("16_rings_on_pad", 16)):
        capsys.readouterr()
        assert main(["challenge", name]) == 0
        title = Scene.from_toml(capsys.readouterr().out).title
        assert title.startswith(f"Challenge {number}: ")


def test_a_table_of_cases(tmp_path, capsys):
    lines = ["radius_over_thickness,poisson_ratio,stiffness", "1,0.3,2.5", "0.1,0,1.1"]
    (tmp_path / "13_mine.csv").write_text("\n".join(lines), "utf-8")
    assert main(["challenge", str(tmp_path / "13_mine.csv")]) == 0
    head, _, row = printed(capsys)
    assert head == HEAD
    case = "radius_over_thickness = 0.1, poisson_ratio = 0"
    assert row == f"| 13 | 13_mine | stiffness | 2 | 1.6e-2 | {case} |"
    (tmp_path / "13_mine.csv").write_text("a,b\n1,2\n", "utf-8")
    assert main(["challenge", str(tmp_path / "13_mine.csv")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_contact_of_the_ball_over_the_radius(tmp_path, capsys):
    """A table without Poisson's ratios belongs to the case of the scene."""
    (tmp_path / "14_mine.csv").write_text("time,indentation\n0,0.008\n", "utf-8")
    assert main(["challenge", str(tmp_path / "14_mine.csv")]) == 0
    assert "| 14 | 14_mine | 6.6e-3 | not given | unknown |" in printed(capsys)


@pytest.mark.gmsh
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_the_input_file_of_the_road_runs(tmp_path):
    """CalculiX gives the deflection of the answers, less what the clamped arc takes from it."""
    (folder,) = (path.parent for path in layered_problems() if name_of(path).startswith("15"))
    given = (folder / "road.inp").read_text("utf-8")
    (tmp_path / "road.inp").write_text(given, "utf-8")
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    call = {"cwd": tmp_path, "check": True, "stdout": subprocess.DEVNULL, "env": environment}
    subprocess.run(["ccx", "road"], timeout=100, **call)
    surface = (tmp_path / "road.dat").read_text("utf-8").splitlines()[3].split()
    # the arc is at 200 radii; at 1000, where the file has 1.7 MB, half a per cent is missing
    assert -0.03 < -float(surface[2]) / 2.239976367e-2 - 1 < -0.02
