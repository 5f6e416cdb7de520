"""What the pages for newcomers say is true: their examples run, and give what they promise."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_the_example_of_the_finite_elements() -> None:
    page = (ROOT / "fem" / "README.md").read_text("utf-8")
    code = re.search(r"\n(    import numpy.*?)\n\n\[1\]", page, re.DOTALL)
    assert code is not None
    done = subprocess.run(
        [sys.executable, "-c", re.sub(r"(?m)^    ", "", code[1])],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr
    found = [float(value) for value in re.findall(r"d0 = (\S+?),?\s", done.stdout)]
    assert len(found) == 2
    assert all(abs(value / 0.5 - 1) < 1e-5 for value in found)
    assert "MeshTri" in done.stdout
    assert "ElementTriP4" in done.stdout


# page: files, and what the page says that they hold
HOLDS = {
    "fem/README.md": {
        "fem/weak_form.py": ("stiffness",),
        "fem/elasticity.py": ("AxisymmetricElasticity",),
        "fem/half_space.py": ("HalfSpace", "saddle_point", "compliance", "pressure_space"),
        "fem/far_field.py": ("poles", "exterior_stiffness", "enough_poles"),
        "meshes/half_space.py": ("turned",),
    },
    "mdr/README.md": {
        "mdr/transforms.py": ("line_density", "panel_quadrature"),
        "mdr/energy.py": ("compliance",),
        "mdr/direct.py": (
            "ring_kernel",
            "disc_displacement",
            "disc_slope",
            "rms_slope",
            "steady_pressures",
            "limiting_profile",
        ),
    },
    "meshes/README.md": {
        "meshes/radial.py": ("alternating_edges", "ring_areas", "ring_of", "graded_breakpoints"),
        "meshes/pressure_space.py": ("PressureSpace", "joined"),
    },
    "studies/README.md": {
        "studies/wear/contact.py": ("flat_start", "steady_state"),
        "studies/wear/archard.py": (
            "RunningIn",
            "modal",
            "implicit",
            "explicit",
            "left",
            "time_to",
        ),
        "studies/wear/modes.py": ("every_mode", "excited_modes"),
        "studies/problem/time_scale.py": ("slowest_relaxation_time",),
        "studies/methods/base.py": ("Method",),
        "studies/methods/estimate.py": ("estimated",),
        "studies/crosscheck/agreement.py": ("agreements",),
        "studies/crosscheck/anchors.py": ("anchors",),
        "studies/crosscheck/operators.py": ("difference",),
        "studies/crosscheck/answer.py": ("answer",),
        "studies/report/printed.py": ("print_result",),
        "studies/report/page.py": ("write_report",),
        "studies/figures/scale.py": ("Scale",),
        "studies/output/folder.py": ("held",),
    },
}


@pytest.mark.parametrize(
    ("page", "file"), [(page, file) for page, files in HOLDS.items() for file in files]
)
def test_functions_that_a_page_points_to_are_there(page: str, file: str) -> None:
    text, code = ((ROOT / name).read_text("utf-8") for name in (page, file))
    for name in HOLDS[page][file]:
        assert name in text
        assert re.search(rf"\b(def|class) {name}\b", code)


@pytest.mark.parametrize("page", HOLDS)
def test_every_source_of_a_page_is_cited(page: str) -> None:
    text = (ROOT / page).read_text("utf-8")
    sources = set(re.findall(r"(?m)^\[(\d)\] .*(?:19|20)\d\d|(?m:^\[(\d)\])", text))
    numbers = {first or second for first, second in sources}
    assert numbers
    for number in numbers:
        assert text.count(f"[{number}]") >= 2


def test_the_readme_names_every_command_and_flag_of_run() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    for told in (
        "ringwear run",
        "ringwear plan",
        "ringwear mesh",
        "ringwear compare",
        "ringwear study",
        "ringwear scenes",
        "--no-figures",
        "--no-report",
        "--csv",
        "--version",
    ):
        assert told in text
