"""Compare runs of random scenes with an independent solution.

Every number of the answer and of the results is compared in its norm. A number is *silent* if its
error is above rtol and the run does not report this: the quantity is not in the list of quantities
beyond rtol, its verdict is "agree", and it is not left out of the promise. An error estimate above
rtol beside the number does not count as a report.
"""

from dataclasses import dataclass, field

import numpy as np
from independent import ROUNDOFF, errors_less_doubts, load_of, solved

from ringwear import Scene, differences, run
from ringwear.studies.crosscheck.result.words import Account

Array = np.ndarray
KINDS = ("flat", "graded", "load", "held", "steep")
# errors of the two independent solutions over rtol; their difference shows how accurate they are
FINE, COARSE = 0.2, 1.0
# relaxation times that are compared
SHOWN_MODES = 8


def draw(kind: str, seed: int, number: int, most_rings: int = 11) -> Scene:
    """Return a scene, which names no methods."""
    random = np.random.default_rng([KINDS.index(kind), seed, number])
    rings = min(int(np.exp(random.uniform(0, np.log(11)))), most_rings)
    if kind in ("graded", "load", "steep"):
        rings = min(rings, 5)
    widths = 10 ** random.uniform(-random.uniform(0, 2), 0, rings)
    edges = np.cumsum(widths / widths.sum())
    edges[-1] = 1.0
    rtol = 10 ** random.uniform(-7, -2)
    radius, modulus, speed = 10 ** random.uniform(-3, 3, 3)
    fastest = 10 ** random.uniform(-3, 3)
    punch: dict = {"radius": radius, "ring_edges": (radius * edges).tolist()}
    punch["ring_edges"][-1] = radius
    if kind == "steep":
        radii, values = _steep_table(random)
        table = {"radii": (radius * radii).tolist(), "values": (fastest * values).tolist()}
        punch["wear_coefficient"] = table
    elif kind == "graded":
        knots = random.integers(2, 6)
        radii = np.sort(random.uniform(0, 1, knots))
        radii[0], radii[-1] = random.choice([0.0, radii[0]]), random.choice([1.0, radii[-1]])
        if knots > 3 and random.random() < 0.5:
            # a step
            radii[2] = radii[1]
        values = 10 ** random.uniform(-random.uniform(0, 2), 0, knots)
        values *= fastest / values.max()
        table = {"radii": (radius * radii).tolist(), "values": values.tolist()}
        punch["wear_coefficient"] = table
    else:
        power = random.uniform(-6, 6)
        if rings == 1:
            wear = np.ones(1)
        elif rings == 2 or random.random() < 1 / 3:
            wear = np.resize([1.0, 10**power], rings)
        else:
            wear = 10 ** random.uniform(-abs(power), 0, rings)
        punch["wear_coefficients"] = (fastest * wear / wear.max()).tolist()
        if rings == 1:
            punch["wear_coefficients"] *= 2
    unit = radius / modulus / fastest / speed
    first = 10 ** random.uniform(-6, 1)
    times = np.geomspace(first, first * 10 ** random.uniform(0.3, 3), random.integers(1, 7))
    if random.random() < 0.5:
        times = np.append(0.0, times)
    force = 10 ** random.uniform(-3, 3)
    load: dict = {"normal_force": force, "sliding_speed": speed}
    if kind == "held":
        load = {"indentation": radius * 10 ** random.uniform(-4, -1), "sliding_speed": speed}
    if kind == "load":
        knots = np.append(0.0, np.cumsum(random.uniform(0.2, 1, random.integers(1, 5))))
        knots *= times[-1] * random.uniform(0.3, 1.2) / knots[-1]
        forces, speeds = random.uniform(0.2, 1, (2, len(knots)))
        if random.random() < 0.5:
            forces = np.sort(forces)
        if (np.diff(forces) < 0).any():
            # contact may open, and then errors are limited by the size of cells
            rtol = 10 ** random.uniform(-3.5, -2)
        at = (unit * knots).tolist()
        load["normal_force"] = {"times": at, "values": (force * forces).tolist()}
        if random.random() < 0.7:
            load["sliding_speed"] = {"times": at, "values": (speed * speeds).tolist()}
    ratio = random.choice([0.0, 0.3, 0.49, 0.5, random.uniform(0, 0.5)])
    return Scene(
        punch=punch,
        half_space={"plane_strain_modulus": modulus, "poisson_ratio": float(ratio)},
        load=load,
        wear={"times": (unit * times).tolist()},
        accuracy={"rtol": float(rtol)},
        output={"gradient_average": str(random.choice(["line", "area"]))},
    )


def _steep_table(random: np.random.Generator) -> tuple[Array, Array]:
    """Return radii and wear coefficients, over the greatest, that vary by up to four decades."""
    least = 10 ** random.uniform(-4, -1)
    width = 10 ** random.uniform(-5, -0.5)
    centre = random.uniform(0.2, 0.8)
    tables = (
        # all over the face, in a narrow ramp, in a dip or a bump, and everywhere by chance
        ([0.0, 1.0], [least, 1.0]),
        ([0.0, centre, centre + width * (1 - centre), 1.0], [1.0, 1.0, least, least]),
        ([centre * (1 - width), centre, centre + width * (1 - centre)], [1.0, least, 1.0]),
        ([centre * (1 - width), centre, centre + width * (1 - centre)], [least, 1.0, least]),
        (np.sort(random.uniform(0, 1, 5)), 10 ** random.uniform(-4, 0, 5)),
    )
    radii, values = map(np.array, tables[random.integers(len(tables))])
    if random.random() < 0.5:
        radii, values = 1 - radii[::-1], values[::-1]
    return radii, values / values.max()


@dataclass
class Held:
    """Comparison of the results of a scene with the independent solution.

    Parameters
    ----------
    excluded : quantity -> times at which it is left out; an empty list means all times
    lost_contact : whether contact is lost, so that nothing was compared
    beyond : numbers whose error is above rtol
    silent : numbers above rtol that the run does not report
    first : numbers above rtol among the first six lines of the answer
    """

    verdict: str
    excluded: dict[str, list[float]]
    lost_contact: bool
    beyond: list[str] = field(default_factory=list)
    silent: list[str] = field(default_factory=list)
    first: list[str] = field(default_factory=list)


def hold(scene: Scene, *methods: str) -> Held:
    """Run a scene, and compare all of its numbers with the independent solution."""
    problem, rtol = scene.problem, scene.accuracy.rtol
    # both solutions are finer for large rtol, so that their difference shows how accurate they are
    (fine, answer, punch), (coarse, less, _) = (
        solved(problem, part * min(rtol, 1e-3), ROUNDOFF * part / FINE) for part in (FINE, COARSE)
    )
    result = run(scene, methods=list(methods))
    outcome = Held(result.verdict, excluded(result), loses_contact(problem, punch))
    if outcome.lost_contact:
        return outcome
    exact = fine | answer
    doubts = differences(coarse | less, exact, problem.face)
    for method, solution in result.solutions.items():
        for name, error in errors_less_doubts(solution, problem, exact, doubts, SHOWN_MODES):
            over = error > rtol
            if over.any():
                outcome.beyond.append(f"{method} {name}")
                if not _named(outcome, result, method, name, len(error))[over].all():
                    outcome.silent.append(f"{method} {name}")
    shown = [what.replace(" ", "_").lower() for what, *_ in Account(result).answers[:6]]
    outcome.first = [label for label in outcome.beyond if label.split()[1] in shown]
    return outcome


def loses_contact(problem, punch) -> bool:
    """Return whether a pressure would be negative at some time while the force falls."""
    load = load_of(problem)
    if (np.diff(load.forces) >= 0).all():
        return False
    end = load.knots[-1]
    at = np.unique(np.concatenate([np.linspace(0, end, 80)[1:], load.knots[1:]]))
    return punch.least_pressure(punch.pressures(load, at)) < 0


def excluded(result) -> dict[str, list[float]]:
    """Return the times at which quantities are not promised or not decided.

    An empty list means all times.
    """
    summary, names = result.summary, {}
    for row in summary.get("left_out_of_promise", []):
        times = row.get("times")
        listed = isinstance(times, list) and all(isinstance(each, float | int) for each in times)
        names[row["quantity"]] = [*names.get(row["quantity"], []), *(times if listed else [])]
    for row in result.agreement:
        if row.verdict != "agree":
            names.setdefault(row.quantity, [])
    return names


def _named(outcome: Held, result, method: str, name: str, count: int) -> Array:
    """Return which values (count,) of a quantity the run reports as beyond rtol or left out."""
    problem, beyond = result.scene.problem, result.summary["methods"][method]["beyond_rtol"]
    # the list of quantities beyond rtol considers three relaxation times
    named = np.full(count, name in beyond)
    if name in beyond and name == "relaxation_time":
        named[3:] = False
    if name in outcome.excluded:
        left_out = outcome.excluded[name]
        if not left_out or count != len(problem.compared_rows):
            return np.full(count, True)
        times = problem.times[problem.compared_rows] * problem.units.time
        named |= np.isclose(times[:, None], left_out, rtol=1e-6, atol=0.0).any(axis=1)
    return named
