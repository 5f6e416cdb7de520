"""Faults of the computation: the code itself is patched, and then a scene is run."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from ringwear import Compliance, Loading, PressureSpace, Problem, Rings, RunningIn, method
from ringwear.studies.crosscheck.methods.sampling import functions, sampler
from ringwear.studies.crosscheck.wear import full_contact
from ringwear.studies.crosscheck.wear.modes import Modes

Put = Callable[[pytest.MonkeyPatch], None]


def change_result(owner, name: str, change: Callable) -> Put:
    """Change what a function returns."""

    def put(patch):
        right = getattr(owner, name)
        patch.setattr(owner, name, lambda *given, **named: change(right(*given, **named)))

    return put


def pose(change: Callable[[Problem], dict]) -> Put:
    """Replace parts of the non-dimensional problem of a scene."""
    return change_result(
        Problem, "from_tables", lambda problem: replace(problem, **change(problem))
    )


def unit(**factors: float) -> Put:
    """Scale units wrongly when a scene becomes a non-dimensional problem."""

    def change(problem):
        units = problem.units
        parts = {name: getattr(units, name) * factor for name, factor in factors.items()}
        return {"units": replace(units, **parts)}

    return pose(change)


def rings(edges=None, wear=None) -> Put:
    """Change ring edges and wear coefficients of the punch."""

    def change(problem):
        right_edges, (right_wear, _) = problem.rings
        new_edges = right_edges if edges is None else edges(right_edges.copy())
        worn = right_wear if wear is None else wear(right_wear.copy())
        return {"rings": Rings.constant(new_edges, worn)}

    return pose(change)


def graded(change: Callable[[Rings], Rings]) -> Put:
    """Change the wear coefficient along the radius."""
    return pose(lambda problem: {"graded": change(problem.graded)})


def load(change: Callable[[Loading], Loading]) -> Put:
    return pose(lambda problem: {"loading": change(problem.loading)})


def times(change: Callable) -> Put:
    return pose(lambda problem: {"times": change(problem.times)})


def heights(factor: float) -> Put:
    """Scale the heights of the unworn face."""

    def change(problem):
        profile = problem.profile
        taller = tuple(
            lambda radii, height=height: factor * height(radii) for height in profile.heights
        )
        return {"profile": replace(profile, heights=taller)}

    return pose(change)


def scale_one(values, index, factor):
    values[index] *= factor
    return values


def stiffness(size: float, *names: str) -> Put:
    """Make the half-space of methods too soft; of the MDR, if no other is given."""

    def soften(compliance):
        return Compliance(compliance.space, compliance.factor * np.sqrt(1 + size))

    def change(ready):
        softer, coarser = soften(ready.compliance), ready.coarser
        return replace(ready, compliance=softer, coarser=lambda: soften(coarser()))

    def put(patch):
        for name in names or ("mdr",):
            change_result(type(method(name)), "discretise", change)(patch)

    return put


def weights(size: float) -> Put:
    """Overestimate the force of every pressure."""
    return change_property(PressureSpace, "weights", lambda right: (1 + size) * right)


def lose_mode(number: int) -> Put:
    def change(modes):
        others = np.arange(len(modes.relaxation)) != number - 1
        return replace(
            modes,
            relaxation=modes.relaxation[others],
            shapes=modes.shapes[:, others],
            amplitudes=modes.amplitudes[others],
            exact=modes.exact - 1,
        )

    return change_result(full_contact, "every_mode", change)


def change_mode(number: int, size: float, name: str = "relaxation") -> Put:
    """Scale the relaxation time or the amplitude of a mode."""

    def change(modes):
        one = 1 + size * (np.arange(len(modes.relaxation)) == number - 1)
        return replace(modes, **{name: getattr(modes, name) * one})

    return change_result(full_contact, "every_mode", change)


def change_property(owner, name: str, change: Callable) -> Put:
    """Change the value of a property."""

    def put(patch):
        right = getattr(owner, name)
        compute = getattr(right, "func", None) or right.fget
        patch.setattr(owner, name, property(lambda of: change(compute(of))))

    return put


def change_steady(name: str, size: float) -> Put:
    """Scale a part of the steady state wherever it is used."""

    def change(state):
        return replace(state, **{name: getattr(state, name) * (1 + size)})

    return change_property(RunningIn, "steady", change)


def mix_modes(angle: float, keep_energies: bool = False) -> Put:
    """Rotate the second and the third mode into each other.

    They stay orthonormal with the weight k, or they keep their energies with the compliance.
    """
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def change(modes):
        scale = np.sqrt(modes.relaxation[1:3]) if keep_energies else 1.0
        shapes = modes.shapes.copy()
        shapes[:, 1:3] = (shapes[:, 1:3] / scale) @ turn * scale
        return replace(modes, shapes=shapes)

    return change_result(full_contact, "every_mode", change)


def area_in_place_of_line() -> Put:
    """Average the RMS slope over the area instead of the radius."""

    def put(patch):
        patch.setattr(functions, "radial_weight", lambda radii, *_: 2 * radii)

    return put


def change_state(**parts: float) -> Put:
    """Scale force, distance or work at a time, as a wrong integration would do."""

    def change(state):
        return state._replace(**{name: getattr(state, name) * of for name, of in parts.items()})

    return change_result(Loading, "at", change)


def forget_knots() -> Put:
    """Leave the increments of the force after the start out of the modes."""
    return change_result(Modes, "at_knots", lambda at: at * 0.0)


def move_force(size: float) -> Put:
    def change(forces):
        moved = np.zeros(forces.shape[1])
        moved[:2] = -size, size
        return forces + moved * forces.sum(axis=1)[:, None]

    return change_result(sampler.Sampler, "ring_forces", change)


def sampled(name: str, size: float) -> Put:
    """Scale a quantity that is sampled from the state of a punch."""
    return change_result(sampler.Sampler, name, lambda values: values * (1 + size))


ANY: dict[str, Put] = {
    "unit of length": unit(length=1.01),
    "unit of the modulus: E for E*": unit(modulus=1 - 0.4**2),
    "unit of force": unit(force=1.01),
    "unit of time": unit(time=1.01),
    "unit of the wear coefficient": unit(wear_coefficient=1.01),
    "times delayed": times(lambda times: 1.02 * times),
    "force moved to another ring": move_force(0.02),
    "greatest displacement": sampled("greatest", 0.02),
    "slopes averaged over the area": area_in_place_of_line(),
}
FULL: dict[str, Put] = {
    "compliance": stiffness(2e-3),
    "compliance, by much": stiffness(0.1),
    "weights of the pressure": weights(1e-3),
    "first mode lost": lose_mode(1),
    "second mode lost": lose_mode(2),
    "slowest mode too slow": change_mode(1, 2e-3),
    "second mode too slow": change_mode(2, 1e-2),
    "slowest mode excited too much": change_mode(1, 1e-2, "amplitudes"),
}
MODES: dict[str, Put] = {
    "third mode lost": lose_mode(3),
    "sixth mode lost": lose_mode(6),
    "pressures of the second mode": change_mode(2, 3e-3, "shapes"),
    "two modes mixed": mix_modes(3e-3),
    "two modes mixed, with their energies": mix_modes(3e-3, keep_energies=True),
    "whole change of the running-in": change_property(
        RunningIn, "total_change", lambda right: 1.01 * right
    ),
}
ON_RINGS: dict[str, Put] = {
    "k of one ring": rings(wear=lambda k: scale_one(k, 2, 1.02)),
    "k of the first ring": rings(wear=lambda k: scale_one(k, 0, 1.05)),
    "k of rings swapped": rings(wear=lambda k: k[[1, 0, 2, 3, 4]]),
    "one ring edge": rings(edges=lambda edges: scale_one(edges, 2, 1.01)),
    "even ring edges": rings(edges=lambda edges: np.linspace(0, 1, len(edges))),
}
STEADY: dict[str, Put] = {
    "steady pressure": change_steady("pressure", 2e-3),
    "steady displacement": change_steady("displacement", 2e-3),
    "steady wear rate": change_steady("wear_rate", 2e-3),
    "steady moments": change_steady("moments", 2e-3),
}


LOADS: dict[str, Put] = {
    "knots of the load delayed": load(lambda of: replace(of, times=1.02 * of.times)),
    "a force of one knot": load(lambda of: replace(of, forces=of.forces * [1, 1.02, 1, 1])),
    "forces of the knot before": load(
        lambda of: replace(of, forces=np.append(of.forces[0], of.forces[:-1]))
    ),
    "the first force everywhere": load(lambda of: replace(of, forces=of.forces[0] + 0 * of.forces)),
    "constant speed": load(lambda of: replace(of, speeds=np.ones_like(of.speeds))),
    "mean speed": load(lambda of: replace(of, speeds=of.speeds.mean() + 0 * of.speeds)),
    "a speed of one knot": load(lambda of: replace(of, speeds=of.speeds * 0.98)),
    "the last knot lost": load(lambda of: Loading(of.times[:-1], of.forces[:-1], of.speeds[:-1])),
}
# not used for marches, where such a fault would also make two uses of the load inconsistent
STATES: dict[str, Put] = {
    "sliding distance": change_state(distance=1.02, slid=1.02),
    "work": change_state(work=1.02),
    "force at times": change_state(force=1.02),
    "knots forgotten": forget_knots(),
}
FACES: dict[str, Put] = {
    "curvature of the face": heights(1.05),
    "curvature of the face, by little": heights(0.97),
    "k of the inner ring": rings(wear=lambda k: scale_one(k, 0, 1.1)),
    "k of rings swapped": rings(wear=lambda k: k[::-1]),
    "the ring edge": rings(edges=lambda edges: scale_one(edges, 1, 1.1)),
    "compliance": stiffness(0.05),
    "volumes": sampled("worn_volumes", 0.05),
}
GRADED: dict[str, Put] = {
    "k of r in steps": graded(
        lambda of: Rings.constant(of.ring_edges, of.wear_coefficients.mean(axis=0))
    ),
    "k of r turned": graded(lambda of: Rings(of.ring_edges, of.wear_coefficients[::-1])),
    "k of r shifted": graded(
        lambda of: Rings(
            of.ring_edges + 0.02 * of.ring_edges * (1 - of.ring_edges), of.wear_coefficients
        )
    ),
    "k of r, one value": graded(
        lambda of: Rings(of.ring_edges, scale_one(of.wear_coefficients.copy(), (1, 0), 1.05))
    ),
    "k of r, the rim": graded(
        lambda of: Rings(of.ring_edges, scale_one(of.wear_coefficients.copy(), (1, -1), 1.05))
    ),
    "k of r to a power": graded(lambda of: Rings(of.ring_edges, of.wear_coefficients**1.05)),
    "harmonic for arithmetic means": rings(wear=lambda k: k * 1.02),
}
BY_KIND: dict[str, dict[str, Put]] = {
    "flat": ANY | FULL | MODES | ON_RINGS | STEADY,
    "graded": FULL | MODES | GRADED | STEADY,
    "rising": ON_RINGS | LOADS | STATES,
    "held": FULL | ON_RINGS,
    "up_and_down": LOADS,
    "sphere": FACES,
}


def faults(kind: str) -> Iterator[tuple[str, Put]]:
    """Yield the name of each fault for a kind of scene, and its patch of the code."""
    yield from BY_KIND[kind].items()
