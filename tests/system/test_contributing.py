"""The lists of CONTRIBUTING.md are complete for a quantity and a study, which are added here."""

import re
import sys
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
import pytest
import xarray

import ringwear.studies
from ringwear import Scene, run, study
from ringwear.studies.crosscheck.anchors import anchor, checks
from ringwear.studies.crosscheck.methods.sampling import sampler
from ringwear.studies.crosscheck.problem import fields, punch, quantities
from ringwear.studies.named_studies import STUDIES, NamedStudy

CONTRIBUTING = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text("utf-8")


def files_named_for(thing):
    """Return the files that the list of CONTRIBUTING.md names for a new thing."""
    entry = re.search(
        rf"^- \*\*{thing}\*\*:(.*?)(?=^- |^$)", CONTRIBUTING, re.MULTILINE | re.DOTALL
    )
    return re.findall(r"`([\w/.]+)`", entry[1])


def check_inner_force(report):
    """Compare the force on the innermost ring at the start with that of the flat punch."""
    force = report.take("inner_force")[0]
    inside = 1 - np.sqrt(1 - report.reading.edges[1] ** 2)
    yield anchor.Row(
        "inner force of the flat start", force, inside, report.tolerance("inner_force")[0]
    )


def add_inner_force(patch, factor):
    """Add a quantity: the force on the innermost ring, times a factor that is 1 if it is right."""
    patch.setattr(quantities, "QUANTITIES", quantities.QUANTITIES.copy())

    inner_force = quantities.Quantity(
        "inner_force",
        "time",
        "force",
        "force on the innermost ring",
        lambda state: factor * state.ring_forces[:, 0],
    )
    quantities.QUANTITIES["inner_force"] = inner_force
    # all tables are built from the declarations when the module is imported
    for table in (sampler.QUANTITIES, quantities.DESCRIBED):
        patch.setitem(table, "inner_force", inner_force)
    for module in (sampler, checks):
        patch.setattr(module, "HISTORIES", module.HISTORIES | {"inner_force"})
    check = checks.Check(check_inner_force, "inner_force")
    patch.setattr(checks, "CHECKS", (*checks.CHECKS, check))


@pytest.mark.slow
def test_a_quantity_needs_its_definition_its_value_and_an_anchor(monkeypatch, tmp_path):
    named = files_named_for("a quantity")
    assert named[:2] == ["studies/crosscheck/problem/quantities.py", "studies/crosscheck/anchors/"]
    add_inner_force(monkeypatch, factor=1.0)
    result = run(Scene.load("five_rings").changed(methods=["mdr", "bem"], accuracy__rtol=1e-3))
    # estimates, comparison, anchors and files need no further change
    assert (result.dataset.inner_force_error < 1e-3).all()
    assert result.quantities["inner_force"] == "agree"
    rows = [row for row in result.anchors if row.name == "inner force of the flat start"]
    assert {row.method for row in rows} == {"mdr", "bem"}
    assert all(row.holds for row in rows)
    result.save(tmp_path)
    with xarray.open_dataset(tmp_path / "results.nc") as written:
        inner = written.inner_force.sel(solver="mdr")
        ring = written.ring_force.sel(solver="mdr").isel(ring=0)
        np.testing.assert_allclose(inner, ring, rtol=1e-14)
        assert inner.attrs["long_name"] == "force on the innermost ring"


def test_the_anchor_of_a_new_quantity_detects_a_wrong_value(monkeypatch):
    add_inner_force(monkeypatch, factor=1.01)
    result = run(Scene.load("five_rings").changed(methods=["mdr", "bem"], accuracy__rtol=1e-3))
    assert result.quantities["inner_force"] == "agree"
    assert result.verdict == "disagree"


class Quartic(fields.ProfileSection):
    """Heights f = h r^4."""

    kind: Literal["quartic"]
    height: fields.Positive

    def height_over(self, punch_radius):
        return lambda radii: self.height * radii**4


class QuarticPunch(punch.PunchSection):
    """Punch with a new kind of profile."""

    profile: Quartic | None = fields.optional("a quartic")


class QuarticScene(Scene):
    """Scene of such a punch."""

    punch: QuarticPunch


def test_a_kind_of_profile_needs_a_class_alone(monkeypatch):
    """Within the contact radius c, d = 8/3 h c^4 and F = 2 E* (d c - 8/15 h c^5) (Galin)."""
    named = files_named_for("a kind of profile")
    files = (
        "studies/crosscheck/problem/fields.py",
        "tests/unit/studies/crosscheck/problem/test_heights.py",
    )
    assert set(files) <= set(named)
    monkeypatch.setitem(fields.KINDS, "quartic", Quartic)
    height, radius = 0.1, 0.5
    depth = 8 / 3 * height * radius**4
    scene = QuarticScene(
        methods=["mdr"],
        punch={
            "radius": 1.0,
            "wear_coefficient": 1.0,
            "profile": {"kind": "quartic", "height": height},
        },
        half_space={"plane_strain_modulus": 1.0},
        load={"normal_force": 2 * (depth * radius - 8 / 15 * height * radius**5)},
        wear={"times": [0.0], "steady": False},
        accuracy={"rtol": 1e-3},
    )
    result = run(scene)
    assert result["indentation"].item() == pytest.approx(depth, rel=1e-6)
    assert all(row.holds for row in result.anchors)


@pytest.fixture
def locking(monkeypatch, tmp_path):
    """Add the study of CONTRIBUTING.md: a file in `studies/` and a row in `STUDIES`."""
    (code,) = re.findall(r"^```python\n(.*?)^```", CONTRIBUTING, re.MULTILINE | re.DOTALL)
    assert len(code.splitlines()) <= 40
    (tmp_path / "locking.py").write_text(code, "utf-8")
    folders = [*ringwear.studies.__path__, str(tmp_path)]
    monkeypatch.setattr(ringwear.studies, "__path__", folders)

    row = NamedStudy("locking:locking", 1)
    monkeypatch.setitem(STUDIES, "locking", row)
    yield row
    sys.modules.pop("ringwear.studies.locking", None)


@pytest.mark.slow
@pytest.mark.gmsh
def test_a_study_needs_a_file_and_a_row(locking, command, tmp_path):
    assert "studies/named_studies.py" in files_named_for("a study")
    results = study("locking", quick=True)
    assert results.purpose == locking.purpose
    errors = results.orders.set_index(["case", "way"])["finest error"]
    # linear elements lock near 1/2, those of degree 4 do not
    assert errors["nu = 0.4999", "P1, graded"] > 5 * errors["nu = 0.3", "P1, graded"]
    assert errors["nu = 0.4999", "P4, graded"] < 1e-4
    assert results.answer["way"].tolist() == ["P1, graded", "P2, graded", "P4, graded"] * 2
    assert "Tell which degree of the elements" in command("study --help").out
    printed = command("study locking --quick --out out").out
    assert "orders agree with theory" in printed
    assert len(pd.read_csv(tmp_path / "out" / "locking.csv")) == 12
    assert (tmp_path / "out" / "locking.png").exists()
    # a study takes no shaped punches unless it says so
    assert "leave out punch.recess" in command("study locking sphere --quick --out no", 2).err
