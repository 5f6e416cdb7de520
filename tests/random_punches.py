"""Punches of random shape under random loads, for tests that count verdicts."""

import numpy as np
from natural import natural

KINDS = ("parabola", "cone", "power", "rounded rim", "table", "recess")


def random_punch(seed, rtol=1e-3):
    """Draw a scene for mdr and fem: shape, rings, wear coefficients, load and times.

    Heights are comparable to the indentation of a flat punch under the same force. So contact
    begins on a part of the face and spreads, and it is about full at the last time.
    """
    draw = np.random.default_rng([35, seed])
    kind = KINDS[seed % len(KINDS)]
    count = int(draw.integers(1, 5)) + (kind == "recess")
    edges = np.sort(draw.uniform(0.1, 0.95, count - 1))
    # without very narrow rings, which other tests cover
    edges = [*(float(edge) for edge in edges if edge < 0.95), 1.0]
    edges = [b for a, b in zip([0.0, *edges[:-1]], edges, strict=True) if b - a > 0.04 or b == 1.0]
    punch = {
        "ring_edges": edges,
        "wear_coefficients": [float(k) for k in 10 ** draw.uniform(-1, 0, len(edges))],
    }
    if len(edges) == 1:
        punch["wear_coefficients"] *= 2
    # relative to 0.5, the indentation of a flat punch under the force 1
    height = 0.5 * 10 ** draw.uniform(-1, 1)
    match kind:
        case "parabola":
            punch["profile"] = {"kind": kind, "curvature_radius": 0.5 / height}
        case "cone":
            punch["profile"] = {"kind": kind, "slope": height}
        case "power":
            exponent = float(draw.uniform(1, 6))
            punch["profile"] = {"kind": kind, "coefficient": height, "exponent": exponent}
        case "rounded rim":
            flat = float(draw.uniform(0.3, 0.95))
            radius = (1 - flat) ** 2 / (2 * height)
            punch["profile"] = {
                "kind": "rounded_rim",
                "flat_radius": flat,
                "curvature_radius": radius,
            }
        case "table":
            points = int(draw.integers(4, 8))
            heights = draw.uniform(0, height, points)
            punch["profile"] = {
                "kind": kind,
                "radii": np.linspace(0, 1, points).tolist(),
                "heights": (heights - heights.min()).tolist(),
            }
        case "recess":
            heights = draw.uniform(0, height, len(edges))
            punch["recess"] = (heights - heights.min()).tolist()
    load = {"normal_force": 1.0}
    if draw.random() < 0.2:
        load = {"indentation": float(0.5 * draw.uniform(0.2, 1.0))}
    times = [0.0, *(float(t) for t in height * 10 ** np.linspace(-2, 1, 4))]
    return natural(punch, times, rtol, load=load)
