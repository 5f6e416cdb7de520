"""Scenes in natural units: radius, plane strain modulus and force are 1."""

from ringwear import Scene


def natural(punch, times=(0.0,), rtol=1e-3, methods="mdr fem", **tables):
    """Return a scene of a punch; tables such as `load` replace those in natural units."""
    table = {
        "methods": methods.split(),
        "punch": {"radius": 1.0} | punch,
        "half_space": {"plane_strain_modulus": 1.0},
        "load": {"normal_force": 1.0},
        "wear": {"times": list(times)},
        "accuracy": {"rtol": rtol},
    }
    return Scene.from_table(table | tables)
