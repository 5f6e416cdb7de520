"""Compare finite elements with dimensionality reduction: profiles, pressures, differences."""

from ringwear import Scene, run

scene = Scene.load("five_rings").changed(wear__times=[0.01, 0.1, 1.0])
result = run(scene, methods=["mdr", "fem"])
result.plot("profiles_and_pressures").savefig("fem_against_mdr.png")

print(result.verdict_in_words)
for row in result.agreement:
    print(f"{row.quantity:<24} {row.difference:.1e} of {row.uncertainty:.1e}: {row.verdict}")
