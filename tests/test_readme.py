"""What the pages for newcomers say is true: their examples run, and give what they promise."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def test_the_example_of_the_finite_elements() -> None:
    page = (ROOT / "fem" / "README.md").read_text("utf-8")
    code = re.search(r"\n(    import numpy.*?)\n\n\[1\]", page, re.DOTALL)
    assert code is not None
    done = subprocess.run(
        [sys.executable, "-c", re.sub(r"(?m)^    ", "", code[1])], capture_output=True, text=True, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    found = [float(value) for value in re.findall(r"d0 = (\S+?),?\s", done.stdout)]
    assert len(found) == 2
    assert all(abs(value / 0.5 - 1) < 1e-5 for value in found)
    assert "MeshTri" in done.stdout
    assert "ElementTriP4" in done.stdout


HOLDS = {
    "fem/weak_form.py": ("radial_radial", "radial_axial", "axial_axial", "stiffness"),
    "fem/elasticity.py": ("AxisymmetricElasticity",),
    "fem/half_space.py": ("HalfSpace", "saddle_point", "compliance", "pressure_space"),
    "fem/far_field.py": ("poles", "exterior_stiffness", "enough_poles"),
    "meshes/half_space.py": ("turned",),
}


@pytest.mark.parametrize("file", HOLDS)
def test_functions_that_the_page_points_to_are_there(file: str) -> None:
    page, code = ((ROOT / name).read_text("utf-8") for name in ("fem/README.md", file))
    for name in HOLDS[file]:
        assert name in page
        assert re.search(rf"\b(def|class) {name}\b", code)
