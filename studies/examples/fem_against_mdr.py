"""Finite elements against dimensionality reduction.

Pressures over the radius, and how far they differ.
"""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ringwear import Scene, run

result = run(Scene.load("five_rings").changed(methods=["mdr", "fem"], wear__times=[0.01, 0.1, 1.0]))
data = result.dataset
figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7, 6))
for time in data.time:
    mdr, fem = (data.pressure.sel(solver=name, time=time) for name in ("mdr", "fem"))
    (line,) = above.plot(data.radius, mdr, label=f"MDR, t = {float(time):g}")
    above.plot(
        data.radius[::8],
        fem[::8],
        "o",
        markersize=3,
        color=line.get_color(),
        markerfacecolor="none",
    )
    below.semilogy(data.radius, np.abs(fem / mdr - 1), color=line.get_color())
above.set(ylabel="pressure (marks: FEM)", ylim=(0, 3))
above.legend()
below.set(xlabel="radius", ylabel="relative difference")
figure.savefig("fem_against_mdr.png", dpi=150)

print(result.verdict_in_words)
for row in result.agreement:
    print(
        f"{row.quantity:<24} differs by {row.difference:.1e}, uncertainty {row.uncertainty:.1e}: "
        f"{row.verdict}"
    )
