"""What the dial `rtol` buys, against the closed form of the steady state and a much finer run."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from ringwear import Scene, run

scene = Scene.load("five_rings").changed(methods=["fem"], wear__times=[0.0, 0.1, 1.0])
exact = run(scene.changed(methods=["mdr", "direct"], accuracy__rtol=1e-8)).dataset
table = []
for rtol in (1e-1, 1e-2, 1e-3, 1e-4):
    fem = run(scene.changed(accuracy__rtol=rtol)).dataset.sel(solver="fem")
    indentation = abs(fem.indentation / exact.indentation.sel(solver="mdr") - 1).max()
    slope = abs(fem.steady_rms_slope / exact.steady_rms_slope.sel(solver="direct") - 1)
    table.append((rtol, float(indentation), float(slope)))
    print(f"rtol {rtol:.0e}: indentation {indentation:.1e}, steady slope {slope:.1e}")

asked, *errors = zip(*table, strict=True)
for error, label in zip(errors, ("indentation", "steady RMS slope"), strict=True):
    plt.loglog(asked, error, "o-", label=label)
plt.plot(asked, asked, "k:", label="asked for")
plt.gca().set(xlabel="rtol asked for", ylabel="relative error")
plt.legend()
plt.savefig(Path("convergence.png"), dpi=150)
