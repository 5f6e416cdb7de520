"""Show relaxation times over the thickness of a layer on a rigid base, down to thin layers."""

import matplotlib.pyplot as plt
import numpy as np

from ringwear import Scene, run

layer = {"thickness": 1.0, "youngs_modulus": 1.0, "poisson_ratio": 0.3}
scene = Scene(
    punch={"radius": 1.0, "wear_coefficient": 1.0},
    half_space={"rigid": True, "layers": [layer]},
    load={"normal_force": 1.0, "sliding_speed": 1.0},
)
# a thin layer is a bed of independent springs with the stiffness M / h per area
modulus = 1.0 * (1 - 0.3) / ((1 + 0.3) * (1 - 2 * 0.3))
thicknesses, times = np.geomspace(0.03, 3.0, 13), []
for thickness in thicknesses:
    changed = scene.changed(half_space__layers__0__thickness=float(thickness))
    result = run(changed, methods=["mdr"], rtol=1e-3, quantities=["relaxation_time"])
    times.append(result.dataset.relaxation_time.values[0, :5])
    print(f"h/a = {thickness:.2f}: slowest over fifth {times[-1][0] / times[-1][4]:.2f}")

figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
axes.loglog(thicknesses, times, "o-", markersize=3)
axes.loglog(thicknesses, thicknesses / modulus, "k--")
axes.set(xlabel="thickness of the layer h/a", ylabel="relaxation time (a / (E k v))")
axes.set_title("The five slowest modes of a flat punch on a layer")
axes.legend(["slowest", "2nd", "3rd", "4th", "5th", "springs: h / (M k v)"])
figure.savefig("thin_layers.png", dpi=110)
