"""Random scenes on layered ground. To run many of them:

    python -m tests.physics.random_layers --count 30 --seed 1
    python -m tests.physics.random_layers --count 10 --seed 1 --shaped

This prints a line for each scene, then how often each verdict occurred, and how many scenes left a
quantity out of the promise.
"""

import argparse
import time
from collections import Counter

import numpy as np

from ringwear import RingwearError, Scene, run


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
    punch: dict = {"radius": 1.0, "rings": rings, "wear_coefficients": wear}
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
    return Scene.from_table(
        {
            "methods": ["mdr", "fem"],
            "punch": punch,
            "half_space": ground,
            "load": load,
            "wear": {"times": [0.0, 0.01, 0.1, 1.0]},
            "accuracy": {"rtol": rtol},
        }
    )


def main() -> None:
    """Run scenes, and print their verdicts."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--shaped", action="store_true")
    chosen = parser.parse_args()
    verdicts, excluding = Counter[str](), 0
    for number in range(chosen.count):
        scene, began = random_layers(1000 * chosen.seed + number, chosen.shaped), time.time()
        try:
            result = run(scene)
        except RingwearError as error:
            verdicts["refused"] += 1
            print(number, "refused:", error, flush=True)
            continue
        verdicts[result.verdict] += 1
        left_out = sorted({row["quantity"] for row in result.summary["left_out_of_promise"]})
        excluding += bool(left_out)
        failed = [anchor.name for anchor in result.anchors if not anchor.holds]
        undecided = {row.quantity for row in result.agreement if not row.agrees} - set(left_out)
        print(
            f"{number} {result.verdict} {time.time() - began:.1f} s; left out {left_out}; "
            f"undecided {sorted(undecided)}; anchors that fail {failed}",
            flush=True,
        )
    print(dict(verdicts), "exclude anything:", excluding)


if __name__ == "__main__":
    main()
