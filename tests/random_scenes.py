"""Compare runs of random scenes with an independent solution.

    python -m tests.random_scenes --kind flat --count 40 --seed 7 --methods mdr,fem

Every number of the answer and of the results is compared in its norm. A number is *silent* if its
error is above rtol and the run does not report this: the quantity is not in the list of quantities
beyond rtol, its verdict is "agree", and it is not left out of the promise. An error estimate above
rtol beside the number does not count as a report.
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from ringwear import RingwearError, Scene, differences, run
from ringwear.studies.crosscheck.problem.quantities import ANSWER, DESCRIBED, QUANTITIES
from ringwear.studies.crosscheck.result.words import Account

sys.path.insert(0, str(Path(__file__).parent))

from independent import ROUNDOFF, Load, Pieces, solved

Array = np.ndarray
KINDS = ("flat", "graded", "load", "held", "steep")
# errors of the two independent solutions over rtol; their difference shows how accurate they are
FINE, COARSE = 0.2, 1.0
# relaxation times that are compared
SHOWN_MODES = 8


def draw(kind: str, seed: int, count: int) -> Iterator[dict]:
    """Yield scenes as tables; scene n of a seed is the same for every count."""
    for number in range(count):
        random = np.random.default_rng([KINDS.index(kind), seed, number])
        yield _scene(kind, random)


def _scene(kind: str, random: np.random.Generator) -> dict:
    rings = int(np.exp(random.uniform(0, np.log(11))))
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
    return {
        "punch": punch,
        "half_space": {"plane_strain_modulus": modulus, "poisson_ratio": float(ratio)},
        "load": load,
        "wear": {"times": (unit * times).tolist()},
        "accuracy": {"rtol": float(rtol)},
        "output": {"gradient_average": str(random.choice(["line", "area"]))},
    }


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


def pieces_of(table: dict) -> Pieces:
    """Return k(r) of a scene, linear between ring edges and the radii of its table."""
    punch = table["punch"]
    radius, edges = punch["radius"], np.append(0.0, punch["ring_edges"]) / punch["radius"]
    if "wear_coefficients" in punch:
        wear = np.resize(np.array(punch["wear_coefficients"]), len(edges) - 1)
        wear = wear / wear.max()
        different = np.append(np.diff(wear) != 0, True)
        distinct_edges = np.append(0.0, edges[1:][different])
        return Pieces(distinct_edges, wear[different], wear[different])
    given = punch["wear_coefficient"]
    radii = np.array(given["radii"]) / radius
    values = np.array(given["values"]) / max(given["values"])
    radii = np.concatenate([[0.0], radii, [1.0]])
    values = np.concatenate([values[:1], values, values[-1:]])
    every = np.union1d(edges, radii)
    inner, outer = [], []
    for left, right in pairwise(every):
        number = np.searchsorted(radii, (left + right) / 2) - 1
        low, high = radii[number], radii[number + 1]
        rise = (values[number + 1] - values[number]) / (high - low)
        inner.append(values[number] + rise * (left - low))
        outer.append(values[number] + rise * (right - low))
    return Pieces(every, np.array(inner), np.array(outer))


def load_of(table: dict) -> Load:
    """Return the load of a scene, relative to its greatest force and speed, in natural time."""
    punch, load = table["punch"], table["load"]
    wear = punch.get("wear_coefficients") or punch["wear_coefficient"]["values"]
    count = len(punch["ring_edges"]) if "wear_coefficients" in punch else None
    modulus = table["half_space"]["plane_strain_modulus"]

    def knots(given):
        if isinstance(given, dict):
            return np.array(given["times"]), np.array(given["values"])
        return np.zeros(1), np.array([given])

    forces, speeds = knots(load.get("normal_force", 1.0)), knots(load["sliding_speed"])
    unit = punch["radius"] / modulus / max(wear[:count]) / speeds[1].max()
    at = np.union1d(forces[0], speeds[0])
    both = [np.interp(at, *each) / each[1].max() for each in (forces, speeds)]
    return Load(at / unit, *both)


@dataclass
class Held:
    """Comparison of the results of a scene with the independent solution.

    Parameters
    ----------
    excluded : quantity -> times at which it is left out; an empty list means all times
    beyond : number above rtol -> its true error and its estimate, both over rtol
    silent : numbers above rtol that the run does not report
    first : numbers above rtol among the first six lines of the answer
    unsure : numbers for which the independent solution may err by more than rtol / 2
    """

    table: dict
    rtol: float
    verdict: str = ""
    words: str = ""
    excluded: dict[str, list[float]] = field(default_factory=dict)
    beyond: dict[str, tuple[float, float]] = field(default_factory=dict)
    silent: list[str] = field(default_factory=list)
    first: list[str] = field(default_factory=list)
    unsure: list[str] = field(default_factory=list)
    seconds: float = 0.0
    reference_seconds: float = 0.0
    lost_contact: bool = False
    error: str = ""

    @property
    def failed(self) -> bool:
        return bool(self.silent or self.first or self.error)


def hold(table: dict, methods: tuple[str, ...]) -> Held:
    """Run a scene, and compare all of its numbers with the independent solution."""
    scene = Scene.from_table(table | {"methods": list(methods)})
    outcome, problem = Held(table, scene.accuracy.rtol), scene.problem
    started = time.perf_counter()
    solutions = []
    for part in (FINE, COARSE):
        # both are finer for large rtol, so that their difference shows how accurate they are
        error, average = part * min(outcome.rtol, 1e-3), table["output"]["gradient_average"]
        roundoff = ROUNDOFF * part / FINE
        solutions.append(
            solved(problem, pieces_of(table), load_of(table), error, average, roundoff)
        )
    (fine, answer, punch), (coarse, less, _) = solutions
    outcome.lost_contact = loses_contact(table, punch)
    outcome.reference_seconds = time.perf_counter() - started
    started = time.perf_counter()
    try:
        result = run(scene)
        outcome.verdict = result.verdict
    except (RingwearError, ArithmeticError, ValueError) as error:
        outcome.error = f"{type(error).__name__}: {error}"
        return outcome
    outcome.seconds = time.perf_counter() - started
    outcome.words = Account(result).verdict_line
    outcome.excluded = excluded(result)
    if not outcome.lost_contact:
        doubt = differences(coarse, fine, problem.face)
        _hold_results(outcome, result, fine, doubt)
        _hold_answers(outcome, result, answer, less)
    return outcome


def loses_contact(table: dict, punch) -> bool:
    """Return whether a pressure would be negative at some time while the force falls."""
    load = load_of(table)
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


def _hold_results(outcome: Held, result, fine: dict, doubt: dict) -> None:
    problem = result.scene.problem
    for method, solution in result.solutions.items():
        for name, error in differences(solution.compared, fine, problem.face).items():
            unsure = np.atleast_1d(doubt[name])
            stated = solution.errors.get(name)
            if stated is None:
                stated = np.full(len(unsure), np.nan)
            else:
                stated = np.atleast_1d(solution.compared_error(problem, name))
            error = np.atleast_1d(error)
            if "mode" in DESCRIBED[name].dims:
                error, unsure, stated = (part[:SHOWN_MODES] for part in (error, unsure, stated))
            count = min(map(len, (error, unsure, stated)))
            error, unsure, stated = (part[:count] for part in (error, unsure, stated))
            named = _named(outcome, result, method, name, len(error))
            _judge(outcome, f"{method} {name}", error, stated, 2 * unsure, named)


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


def _hold_answers(outcome: Held, result, answer: dict, less: dict) -> None:
    units = result.scene.problem.units
    shown = [what.replace(" ", "_").lower() for what, *_ in Account(result).answers[:6]]
    for method, given in result.answers.items():
        for name, exact in answer.items():
            if name not in given or name not in ANSWER | QUANTITIES:
                continue
            quantity = (ANSWER | QUANTITIES)[name]
            value = np.asarray(given[name], float) / getattr(units, quantity.unit)
            if not np.isfinite(value).any():
                continue
            some = np.isfinite(value) & np.isfinite(exact)
            scale = np.abs(exact)
            if name in ("worn_volume", "force_share"):
                scale = np.broadcast_to(exact.sum(axis=-1, keepdims=True), exact.shape)
            if name == "force_end":
                # relative to the greatest force so far
                scale = np.ones(())
            if name == "steady_rms_slope":
                scale = np.maximum(scale, 1e-3 * answer["indentation_steady"])
            # pressures at the rim are infinite in both solutions and therefore left out
            error, unsure = (
                np.max(np.abs(part[some] - exact[some]) / scale[some], initial=0.0)
                for part in (value, less[name])
            )
            stated = given.get(f"{name}_error", np.nan)
            stated = result.reported(method).get(f"{name}_error", stated)
            stated = float(np.nanmax(np.atleast_1d(stated), initial=0.0))
            before = set(outcome.beyond)
            label = f"{method} answer {name}"
            numbers = (np.array([number]) for number in (error, stated, 2 * unsure))
            _judge(outcome, label, *numbers, _named(outcome, result, method, name, 1))
            if name in shown and set(outcome.beyond) - before:
                outcome.first.append(label)


def _judge(
    outcome: Held, label: str, error: Array, stated: Array, doubt: Array, named: Array
) -> None:
    rtol = outcome.rtol
    if (doubt > 0.5 * rtol).any():
        outcome.unsure.append(label)
    over = error - doubt > rtol
    if over.any():
        worst = int(np.argmax(np.where(over, error, 0.0)))
        outcome.beyond[label] = float(error[worst] / rtol), float(stated[worst] / rtol)
        if not named[over].all():
            outcome.silent.append(label)


def line_of(outcome: Held, number: int) -> str:
    """Return the line that is printed for a scene."""
    words = f"{number:4} {outcome.rtol:.0e} {outcome.verdict or 'ERROR':9} {outcome.seconds:6.2f} s"
    words += f" (reference {outcome.reference_seconds:5.1f} s)"
    if outcome.lost_contact:
        words += " loses contact: not held"
    for what in ("silent", "first", "excluded", "unsure"):
        if names := getattr(outcome, what):
            words += f" | {what}: " + ", ".join(names)
    if outcome.beyond:
        words += " | beyond: " + ", ".join(
            f"{name} {true:.3g} ({stated:.2g})" for name, (true, stated) in outcome.beyond.items()
        )
    return words + (f" | {outcome.error}" if outcome.error else "")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kind", choices=KINDS, default="flat")
    parser.add_argument("--count", type=int, default=4)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--only", type=int, help="number of the one scene to run")
    parser.add_argument("--methods", default="mdr")
    parser.add_argument("--failures", type=Path, help="folder for scenes that fail, as TOML")
    parser.add_argument("--out", type=Path, help="JSON lines, one for each scene")
    given = parser.parse_args()
    methods, rows = tuple(given.methods.split(",")), []
    for number, table in enumerate(draw(given.kind, given.seed, given.count)):
        if given.only is not None and number != given.only:
            continue
        outcome = hold(table, methods)
        rows.append(outcome)
        print(line_of(outcome, number), flush=True)
        name = f"{given.kind}_{given.seed}_{number}"
        if given.failures and outcome.failed:
            given.failures.mkdir(parents=True, exist_ok=True)
            scene = Scene.from_table(table | {"methods": list(methods), "title": name})
            (given.failures / f"{name}.toml").write_text(scene.to_toml(), "utf-8")
        if given.out:
            row = {key: value for key, value in vars(outcome).items() if key != "table"}
            with given.out.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps({"scene": name, "methods": methods} | row) + "\n")
    count = len(rows)
    verdicts = {
        word: sum(row.verdict == word for row in rows)
        for word in ("agree", "undecided", "disagree", "")
    }
    print(f"{count} scenes: verdicts {verdicts}")
    print(f"silently beyond rtol: {sum(bool(row.silent) for row in rows)} scenes")
    print(f"first six lines beyond rtol: {sum(bool(row.first) for row in rows)} scenes")
    print(f"scenes that exclude anything: {sum(bool(row.excluded) for row in rows)}")
    print(f"not sure themselves: {sum(bool(row.unsure) for row in rows)}; ", end="")
    print(f"lose contact: {sum(row.lost_contact for row in rows)}")


if __name__ == "__main__":
    main()
