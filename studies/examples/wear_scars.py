"""Wear coefficients of balls from the diameters of their scars, after a standard pin-on-disk test.

In the interlaboratory tests of ASTM G99 (table 2; Czichos, Becker, Lexow, Wear 114 (1987) 109),
balls of 10 mm diameter slid over 1 km on disks, at 0.1 m/s. The table has the mean diameters of the
scars, their deviations between laboratories, and volumes, by the geometry of a spherical cap.
"""

import ringwear

STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
ALUMINA = {"youngs_modulus": "370 GPa", "poisson_ratio": 0.22}
TESTS = {  # ball and disk; scar diameter, its deviation, volume of the ball in mm^3
    "steel on steel": (STEEL, STEEL, 2.11, "0.27 mm", 198e-3),
    "steel on alumina": (STEEL, ALUMINA, 2.08, "0.35 mm", 186e-3),
    "alumina on alumina": (ALUMINA, ALUMINA, 0.30, "0.06 mm", 0.08e-3),
}
profile = {"kind": "ball", "ball_radius": 5.0}
for name, (ball, disk, diameter, deviation, volume) in TESTS.items():
    by_volume = volume / 10.0 / 1e6
    scene = {
        "units": "mm, N, MPa, s",
        "punch": {"radius": 3.0, "wear_coefficient": by_volume, "profile": profile},
        "half_space": disk | {f"punch_{key}": value for key, value in ball.items()},
        "load": {"normal_force": 10.0, "sliding_speed": "0.1 m/s"},
    }
    data = {"distance [m]": [1e3], "scar_diameter [mm]": [diameter]}
    found = ringwear.fit(scene, data, "punch.wear_coefficient", noise=deviation).estimates
    value, low, high = 1e3 * found.iloc[0][["value", "low", "high"]]
    print(f"{name}: k = {value:.3g} mm^3/(N m) (95 %: {low:.2g} to {high:.2g}) by the scar,")
    print(f"    V / (F s) = {1e3 * by_volume:.3g}")
