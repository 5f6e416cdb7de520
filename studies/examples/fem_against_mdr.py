"""Finite elements against dimensionality reduction: pressures, and how far they differ."""

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
    color = line.get_color()
    above.plot(data.radius[::8], fem[::8], "o", ms=3, color=color, mfc="none")
    below.semilogy(data.radius, np.abs(fem / mdr - 1), color=color)
above.set(ylabel="pressure (marks: FEM)", ylim=(0, 3))
above.legend()
below.set(xlabel="radius", ylabel="relative difference")
figure.savefig("fem_against_mdr.png", dpi=150)

print(result.verdict_in_words)
for row in result.agreement:
    print(f"{row.quantity:<24} {row.difference:.1e} of {row.uncertainty:.1e}: {row.verdict}")
