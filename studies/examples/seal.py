"""My seal: how long it takes to run in, and what its face looks like then.

A seal is a hollow punch. Both materials carry the load, in inverse proportion to their wear.
"""

from ringwear import run

seal = {
    "units": "SI",
    "punch": {
        "radius": "20 mm",
        "inner_radius": "12 mm",
        "rings": 3,
        "wear_coefficients": ["2e-7 mm^3/(N m)", "1e-6 mm^3/(N m)"],
    },
    "half_space": {"youngs_modulus": "25 GPa", "poisson_ratio": 0.2},
    "load": {"mean_pressure": "0.3 MPa", "sliding_speed": "4 m/s"},
    "wear": {"times": "running-in"},
}
result = run(seal, methods=["mdr", "bem"], rtol=1e-2)
hours = result.answers["mdr"]["time_to_90"].item() / 3600
print(f"90 % of the running-in take {hours:.1f} h.")
print(result.verdict)
result.plot("profiles_and_pressures").savefig("seal.png")
