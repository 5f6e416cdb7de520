"""Scenes with recesses, profiles and fixed indentations.

What they ask for, what is refused, and what results say.
"""

from typing import Any

import numpy as np
import pytest
from closed_forms import PowerPunch

from ringwear import Scene, plan, run, sweep
from ringwear.mdr import energy
from ringwear.meshes.errors import SceneError
from ringwear.studies.cli import main
from ringwear.studies.crosscheck.agreement import AT_EDGES, remedy
from ringwear.studies.figures.catalogue import PICTURES
from ringwear.studies.methods.spaces import load_of
from ringwear.studies.output.files import draw, write_numbers
from ringwear.studies.output.folder import output_folder
from ringwear.studies.problem.defaults import cells_of
from ringwear.studies.wear.contact_edges import located

LENGTH, MODULUS, FORCE = 2.0, 5.0, 0.3
BASE: dict[str, Any] = {
    "methods": ["mdr"],
    "punch": {"radius": LENGTH, "ring_edges": [0.8, 1.4, LENGTH], "wear_coefficients": [1.0, 10.0]},
    "half_space": {"plane_strain_modulus": MODULUS},
    "load": {"normal_force": FORCE},
    "wear": {"times": [0.0, 0.1, 1.0]},
    "accuracy": {"rtol": 1e-3},
}


def scene(**changes):
    return Scene.from_table(BASE).changed(**changes)


def test_a_press_of_a_sphere_in_units():
    known = PowerPunch(1 / (2 * 8.0), 2)  # of curvature radius 8, by a unit modulus
    pressed = scene(punch__profile={"kind": "parabola", "curvature_radius": 8.0}, wear__times=[0.0])
    data = run(pressed).dataset.sel(solver="mdr").isel(time=0)
    contact = known.contact_radius(FORCE / MODULUS)
    assert float(data.contact_radius) == pytest.approx(contact, rel=1e-7)
    assert float(data.indentation) == pytest.approx(known.indentation(contact), rel=1e-8)
    assert float(data.displacement_centre) == pytest.approx(known.indentation(contact), rel=1e-8)
    pressure = MODULUS * known.pressure(contact, np.array(data.radius[1:]))
    assert np.array(data.pressure[1:]) == pytest.approx(pressure, abs=1e-4 * pressure.max())
    assert np.array_equal(np.array(data.contact) > 0, np.array(data.radius) <= contact)
    assert np.array(data.contact_edge) == pytest.approx([0.0, contact])
    assert float(data.normal_force) == pytest.approx(FORCE)


def test_every_way_to_give_a_profile(tmp_path):
    radii = np.linspace(0.0, LENGTH, 41)
    (tmp_path / "profile.csv").write_text(
        "radius,height\n" + "".join(f"{r},{r**2 / 16}\n" for r in radii), "utf-8"
    )
    file = tmp_path / "scene.toml"
    table = scene(
        punch__profile={"kind": "parabola", "curvature_radius": 8.0}, wear__times=[0.0]
    ).to_toml()
    head, _, tail = table.partition("[punch.profile]")
    file.write_text(
        f"{head}[punch.profile]\nkind = 'table'\nfile = 'profile.csv'\n{tail[tail.index('[') :]}",
        "utf-8",
    )
    given = scene(wear__times=[0.0])
    ways = {
        "parabola": Scene.from_toml(table),
        "power": given.changed(
            punch__profile={"kind": "power", "coefficient": LENGTH**2 / 16, "exponent": 2.0}
        ),
        "function": given.with_heights(lambda r: r**2 / 16),
        "sum": given.with_heights(lambda r: r**2 / 32, lambda r: r**2 / 32),
        "table": Scene.load(file),
    }
    found = {name: float(run(one).dataset.indentation[0, 0]) for name, one in ways.items()}
    for name, value in found.items():
        assert value == pytest.approx(found["parabola"], rel=2e-3 if name == "table" else 1e-9), (
            name
        )
    # the scene is complete without its file, and functions stay with it
    assert Scene.from_toml(ways["table"].to_toml()) == ways["table"]
    assert ways["function"].changed(accuracy__rtol=1e-2).punch.heights


def test_recesses_and_profiles_add():
    one = scene(punch__recess=[0.0, 0.02, 0.01]).with_heights(lambda r: 0.1 * r).problem.profile
    heights = one(np.array([0.1, 0.5, 0.9])) * scene().problem.units.displacement
    assert heights == pytest.approx([0.02, 0.12, 0.19])


@pytest.mark.parametrize("recess", [[0.0, 0.0, 0.0], None])
def test_a_flat_face_keeps_its_own_way(recess):
    flat = scene(**({} if recess is None else {"punch__recess": recess}))
    assert flat.problem.full_contact
    result = run(flat)
    assert "contact" not in result.dataset
    assert result.solutions["mdr"].wear is not None


@pytest.mark.gmsh
def test_results_say_where_contact_is(tmp_path):
    recessed = scene(methods=["mdr", "direct", "fem"], punch__recess=[0.0, 0.01, 0.0])
    result = run(recessed)
    assert result.verdict == "agree"
    undecided = {row.quantity for row in result.agreement if not row.agrees}
    assert undecided
    assert undecided <= set(AT_EDGES)
    assert all(anchor.holds for anchor in result.anchors)
    data = result.dataset
    assert float(data.contact_edge.sel(solver="fem").isel(time=0, edge=1)) == pytest.approx(0.8)
    for name in ("indentation", "ring_force", "ring_worn_volume", "contact_radius"):
        assert np.isfinite(data[f"{name}_error"].sel(solver="mdr")).all()
    # each ring wears k times what it carries, all rings together F v0 t
    worn = data.ring_worn_volume.sel(solver="mdr") / np.array([1.0, 10.0, 1.0])
    assert np.array(worn.sum("ring")) == pytest.approx(FORCE * np.array([0.0, 0.1, 1.0]), rel=1e-12)
    assert any("springs' rule" in note for note in result.notes)
    with output_folder(tmp_path, "run") as folder:
        write_numbers(result, folder.hidden, True)
        assert not draw(result, PICTURES, folder.hidden)
    assert {"contact.png", "history.png", "results.nc", "contact_edges.csv"} <= {
        file.name for file in tmp_path.iterdir()
    }
    assert not {"half_space.vtu", "stress.png"} & {file.name for file in tmp_path.iterdir()}
    assert "springs' rule of the MDR" in result.summary["left_out"]


def test_a_remedy_is_an_accuracy_to_ask_for():
    for problem in (scene().problem, scene(punch__recess=[0.0, 0.02, 0.01]).problem):
        told = remedy(problem, "indentation", "mdr", 1e-2)
        assert told.endswith("rtol = 1e-04 would decide it")


def test_what_is_of_flat_punches_only_is_refused_before_it_is_computed(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr("ringwear.studies.crosscheck.run.solved_to_accuracy", None)
    shaped = scene(punch__profile={"kind": "parabola", "curvature_radius": 8.0})
    refused = shaped.changed(output__field_times=[0.1])
    (tmp_path / "scene.toml").write_text(refused.to_toml(), "utf-8")
    assert main(["run", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "out")]) == 2
    assert "output.field_times" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


# first contacts whose cells came back every second, third, ... look, until the looks ran out
CIRCLING = {
    "every second": (
        [0.199, 0.208, 0.347, 0.769, 1.0],
        [0.0044, 0.015, 0.004, 0.011, 0.015],
        1100.0,
        0.048,
        1e-2,
    ),
    "every third": ([0.152, 0.204, 0.711, 1.0], [0.12, 0.2, 0.062, 0.24], None, 1.0, 1e-3),
    "always the same": ([0.205, 0.495, 1.0], [0.00017, 0.00036, 0.0004], None, 5.6e-5, 1e-4),
}


@pytest.mark.parametrize("name", CIRCLING)
def test_first_contact_is_located_in_a_few_looks(name):
    edges, recess, curvature_radius, force, rtol = CIRCLING[name]
    punch: dict[str, Any] = {
        "radius": 1.0,
        "ring_edges": edges,
        "wear_coefficients": [1.0, 2.0],
        "recess": recess,
    }
    if curvature_radius is not None:
        punch["profile"] = {"kind": "parabola", "curvature_radius": curvature_radius}
    table = BASE | {
        "punch": punch,
        "load": {"normal_force": force},
        "half_space": {"plane_strain_modulus": 1.0},
    }
    problem = Scene.from_table(table | {"accuracy": {"rtol": rtol}}).problem
    looks = []

    def look(space):
        looks.append(space)
        return energy.compliance(space)

    assert not problem.full_contact
    intervals, _ = located(look, problem.profile, load_of(problem), cells_of(problem))
    assert intervals
    assert len(looks) <= 4


def test_first_contact_is_located_once_for_all_methods(monkeypatch):
    looked_for = []

    def count(*arguments):
        looked_for.append(arguments)
        return located(*arguments)

    monkeypatch.setattr("ringwear.studies.methods.spaces.located", count)
    run(scene(methods=["mdr", "bem"], punch__recess=[0.0, 0.02, 0.01], accuracy__rtol=1e-2))
    # on the cells of the result, and on half as many for its error
    assert len(looked_for) == 2


def test_the_answer_is_that_of_this_punch(tmp_path):
    """Recessed material is not worn material, and no time scale of a flat punch is told as that of
    this one.
    """
    one = scene(punch__profile={"kind": "parabola", "curvature_radius": 8.0})
    answer = run(one).answers["mdr"]
    known = PowerPunch(1 / (2 * 8.0), 2)
    first = known.indentation(known.contact_radius(FORCE / MODULUS))
    assert float(answer["indentation_start"]) == pytest.approx(first, rel=1e-8)
    # F v0 t, shared out by the k of the rings that have touched
    assert np.sum(answer["worn_volume"] / np.array([1.0, 10.0, 1.0])) == pytest.approx(
        FORCE, rel=1e-12
    )
    assert answer["force_share"].sum(axis=1) == pytest.approx([1.0, 1.0], rel=1e-8)
    for name in ("running_in_time", "time_to_90", "time_to_99"):
        assert np.isnan(answer[name]), name
    assert np.isnan(answer["pressure_max"][0]).all()
    (tmp_path / "scene.toml").write_text(one.to_toml(), "utf-8")
    assert main(["run", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "out")]) in (0, 3)
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "of the unworn face plane" in page
    assert "flat punch</td>" not in page


def test_sweeps_refuse_at_the_door():
    with pytest.raises(SceneError, match="sweeps are over flat punches"):
        sweep("sphere", {"accuracy.rtol": [1e-2, 1e-3]})
    with pytest.raises(SceneError, match="sweeps are over flat punches"):
        sweep(scene(), {"punch.recess": [[0.0, 0.0, 0.0], [0.0, 0.1, 0.0]]})
    with pytest.raises(SceneError, match="no quantity of a flat punch"):
        sweep(scene(), {"accuracy.rtol": [1e-2, 1e-3]}, keep=["contact_radius"])


def test_running_in_times_are_those_of_flat_punches():
    with pytest.raises(SceneError, match="known for flat punches"):
        scene(punch__recess=[0.0, 0.01, 0.0], wear__times="running-in")
    with pytest.raises(SceneError, match="known for flat punches"):
        scene(wear__times={"tau": [0.1, 1.0]}).with_heights(lambda r: r)


def test_heights_are_added_after_the_problem_was_looked_at():
    one = scene()
    assert one.problem.full_contact
    assert not one.with_heights(lambda r: r).problem.full_contact


def test_a_fixed_indentation():
    fixed = scene(
        load={"indentation": 0.02},
        punch__profile={"kind": "cone", "slope": 0.01},
        wear__times=[0.0, 1.0, 10.0, 1e4],
    )
    data = run(fixed).dataset.sel(solver="mdr")
    cone = PowerPunch(0.01, 1)
    contact = 0.02 / cone.indentation(1.0)
    assert float(data.normal_force[0]) == pytest.approx(MODULUS * cone.force(contact), rel=1e-7)
    assert float(data.contact_radius[0]) == pytest.approx(contact, rel=1e-6)
    assert np.array(data.indentation) == pytest.approx(np.full(4, 0.02))
    assert (np.diff(data.normal_force) <= 0).all()
    assert float(data.normal_force[-1]) < 1e-11 * MODULUS
    assert np.isnan(data.steady_wear_rate)
    # in the end all that is higher than the indentation has worn off
    profile, radii = np.array(data.profile[-1]), np.array(data.radius)
    assert profile == pytest.approx(np.full(len(radii), 0.02), abs=1e-5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"punch__recess": [0.0, 0.1]}, ["recess", "3 rings"]),
        ({"punch__recess": [0.0, -0.1, 0.0]}, ["recess", "0 or more"]),
        ({"punch__profile": {"kind": "cone"}}, ["profile", "slope"]),
        (
            {"punch__profile": {"kind": "cone", "slope": 1.0, "exponent": 2.0}},
            ["exponent", "did you mean", "slope"],
        ),
        ({"punch__profile": {"kind": "spere"}}, ["profile.kind", "parabola"]),
        (
            {"punch__profile": {"kind": "table", "file": "nowhere.csv"}},
            ["nowhere.csv", "cannot be read"],
        ),
        (
            {
                "punch__profile": {
                    "kind": "table",
                    "radii": [0.0, 1.0, 1.0, 2.0],
                    "heights": [0.0, 1, 2, 3],
                }
            },
            ["step", "recess"],
        ),
        (
            {"punch__profile": {"kind": "table", "radii": [0.0, 1.0], "heights": [0.0, 1.0]}},
            ["radii", "rim"],
        ),
        (
            {
                "punch__profile": {
                    "kind": "table",
                    "radii": [0.0, 2.0],
                    "heights": [0.0, float("nan")],
                }
            },
            ["heights"],
        ),
        (
            {
                "punch__profile": {
                    "kind": "rounded_rim",
                    "flat_radius": 3.0,
                    "curvature_radius": 1.0,
                }
            },
            ["flat_radius"],
        ),
        ({"load": {"indentation": 0.1, "normal_force": 1.0}}, ["indentation", "normal_force"]),
    ],
)
def test_what_is_no_punch_is_refused(changes, words):
    with pytest.raises(SceneError) as caught:
        scene(**changes)
    assert all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"methods": ["mdr-grid"]}, ["mdr-grid", "q = d - g", "disc"]),
        (
            {"wear": {"times": [0.0, 1.0], "march": "explicit", "step": 0.1}},
            ["explicit", "implicit"],
        ),
        ({"accuracy": {"mdr": {"degree": 4}}}, ["accuracy.mdr"]),
        ({"methods": ["fem"], "accuracy": {"fem": {"truncation": 4.0}}}, ["accuracy.fem"]),
        ({"load": {"indentation": 0.1}, "wear__times": []}, ["indentation", "wear.times"]),
        ({"load": {"indentation": 0.1}, "methods": ["direct"]}, ["direct", "indentation"]),
    ],
)
def test_what_cannot_be_done_is_refused(changes, words):
    one = scene(**({"punch__recess": [0.0, 0.01, 0.0]} | changes))
    with pytest.raises(SceneError) as caught:
        run(one)
    assert all(word in str(caught.value) for word in words), caught.value
    assert any(line.startswith("refused: ") for line in plan(one))


def test_an_indentation_that_does_not_touch_is_refused():
    with pytest.raises(SceneError, match=r"too small to touch: the punch stands 0\.01 "):
        run(scene(punch__recess=[0.01, 0.02, 0.01], load={"indentation": 0.005}))


def test_negative_heights_are_refused():
    with pytest.raises(SceneError, match="missing, 0 or more"):
        _ = scene().with_heights(lambda r: r - 0.5).problem


def test_studies_of_flat_punches_refuse(capsys):
    assert main(["study", "truncation", "sphere"]) == 2
    assert "flat punches" in capsys.readouterr().err


def noise(radii):
    return 1e-3 * (1 + np.sin(1e4 * radii) * np.cos(3e3 * radii**2))


@pytest.mark.parametrize(
    "case",
    [
        "never touches",
        "plateau",
        "noise",
        "far apart",
        *(pytest.param(one, marks=pytest.mark.slow) for one in ("no width", "one point")),
    ],
)
def test_degenerate_faces_converge(case):
    radii, heights = [0.0, 0.7, 0.8, 2.0], [0.01, 0.01, 0.0, 0.0]
    faces = {
        "never touches": scene(punch__recess=[0.0, 10.0, 0.0]),
        "no width": scene(punch__profile={"kind": "cone", "slope": 1e3}),
        "plateau": scene(punch__profile={"kind": "table", "radii": radii, "heights": heights}),
        "noise": scene().with_heights(noise),
        "far apart": scene(punch__recess=[5.0, 5.0, 0.0]),
        "one point": scene(punch__profile={"kind": "parabola", "curvature_radius": 1e-3}),
    }
    result = run(faces[case].changed(wear__steady=False))
    data = result.dataset.sel(solver="mdr")
    assert (np.array(data.pressure) >= -1e-6 * np.array(data.pressure).max()).all()
    assert np.array(data.normal_force) == pytest.approx(np.full(3, FORCE), rel=1e-8)
    assert np.isfinite(data.indentation).all()
