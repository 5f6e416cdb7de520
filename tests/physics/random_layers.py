"""Random scenes on layered ground."""

import numpy as np
from natural import natural

from ringwear import Scene


def random_layers(seed: int, shaped: bool = False, rtol: float = 1e-4) -> Scene:
    """Return a scene of one to three layers under one to eight rings, by MDR and FEM."""
    draw = np.random.default_rng([seed, shaped])
    count = int(draw.integers(1, 4))
    moduli = 10 ** draw.uniform(-1, 1, count + 1)
    ratios = draw.uniform(0, 0.45, count + 1)
    layers = [
        {"thickness": float(thickness), "youngs_modulus": float(modulus), "poisson_ratio": ratio}
        for thickness, modulus, ratio in zip(
            10 ** draw.uniform(-1.2, 0.4, count), moduli, ratios.tolist(), strict=False
        )
    ]
    ground: dict = {"layers": layers}
    if draw.random() < 0.3:
        ground["rigid"] = True
    else:
        ground |= {"youngs_modulus": float(moduli[-1]), "poisson_ratio": float(ratios[-1])}
    rings = int(draw.integers(1, 9))
    wear = (10 ** draw.uniform(-1.5, 0, max(rings, 2))).tolist()
    punch: dict = {"rings": rings, "wear_coefficients": wear}
    load: dict = {"normal_force": 1.0}
    if draw.random() < 0.3:
        punch["inner_radius"] = float(draw.uniform(0.1, 0.9))
    if shaped:
        punch["profile"] = {"kind": "parabola", "curvature_radius": float(10 ** draw.uniform(0, 1))}
        if draw.random() < 0.5:
            flat = float(draw.uniform(0.5, 0.95))
            punch["profile"] = {"kind": "rounded_rim", "flat_radius": flat, "curvature_radius": 1.0}
    if draw.random() < 0.3:
        load = {"indentation": float(draw.uniform(0.1, 1.0))}
    return natural(punch, [0.0, 0.01, 0.1, 1.0], rtol, half_space=ground, load=load)
