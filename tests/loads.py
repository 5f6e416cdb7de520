"""Loads on a flat punch, one of each kind."""

from ringwear import Scene

RISING = {"times": [0.0, 1.0], "values": [1.0, 2.0]}
FALLING = {"times": [0.0, 1.0], "values": [2.0, 0.2]}
FALLING_SLOWLY = {"times": [0.0, 1.0], "values": [2.0, 1.0]}
LOADS = {
    "force": {"normal_force": 1.0},
    "rising": {"normal_force": RISING},
    "falling": {"normal_force": FALLING},
    "falling slowly": {"normal_force": FALLING_SLOWLY},
    "speed": {"normal_force": 1.0, "sliding_speed": FALLING},
    "indentation": {"indentation": 1.0},
    "indentation and speed": {"indentation": 1.0, "sliding_speed": FALLING},
}


def pressed_by(**load):
    return Scene.from_table(Scene.load("five_rings").table() | {"load": load})
