"""What people look for in a scene and ringwear does not have, and what to use instead."""

import difflib
from collections.abc import Mapping

from .fields import KINDS, ProfileSection

KINDS_OF_PROFILES = [name for name, section in KINDS.items() if issubclass(section, ProfileSection)]

ROTATION = (
    "give sliding_speed of the rim, and a wear coefficient in proportion to the radius, as in the "
    "scene pin_on_disc"
)
# words in the names of keys, and what to tell of them
WORDS = {
    "friction": "ringwear has no friction: give sliding_speed, and wear coefficients that were "
    "measured with the friction there is",
    "traction": "ringwear has no friction: pressures are normal to the surface",
    "adhesion": "ringwear has no adhesion: contact presses, and does not pull",
    "adhesive": "ringwear has no adhesion: contact presses, and does not pull",
    "surface_energy": "ringwear has no adhesion: contact presses, and does not pull",
    "layer": "ringwear has no layers: the ground is one homogeneous half-space; give the modulus "
    "that an indentation as deep as yours measures",
    "coating": "ringwear has no layers: the ground is one homogeneous half-space; give the modulus "
    "that an indentation as deep as yours measures",
    "substrate": "ringwear has no layers: the ground is one homogeneous half-space",
    "thickness": "ringwear has no layers: the ground is one half-space, infinitely thick",
    "yield": "ringwear has no plasticity: compare the stresses inside, in stress.png and "
    "half_space.vtu, with the yield stress",
    "plastic": "ringwear has no plasticity: compare the stresses inside, in stress.png and "
    "half_space.vtu, with the yield stress",
    "hardness": "Archard's law is written with k = K / H: divide the dimensionless coefficient by "
    "the hardness, and give punch.wear_coefficient",
    "temperature": "ringwear has no temperature: give the wear coefficients and moduli of the hot "
    "state",
    "thermal": "ringwear has no temperature: give the wear coefficients and moduli of the hot "
    "state",
    "exponent": "the wear rate is k p v: for another power of the pressure there is no key; "
    "profile.exponent is that of a power-law face",
    "rough": "ringwear has no statistical roughness: give a measured profile, profile = { kind = "
    "'table', file = ... }",
    "viscosity": "ringwear has no viscoelasticity: give the modulus of the time that the contact "
    "takes",
    "relaxation": "ringwear has no viscoelasticity: give the modulus of the time that the contact "
    "takes",
    "angular": ROTATION,
    "rotation": ROTATION,
    "diameter": "give punch.radius, half of it",
    "shear_modulus": "give youngs_modulus = 2 G (1 + nu) with poisson_ratio = nu",
    "reduced_modulus": "give plane_strain_modulus, or punch_youngs_modulus beside youngs_modulus",
}
# kinds of profiles by other names
OTHER_KINDS = {
    "sphere": "a sphere is a 'parabola' (curvature_radius) where contact is small beside it, and a "
    "'ball' (ball_radius) to all digits",
    "spherical": "a sphere is a 'parabola' (curvature_radius) where contact is small beside it, "
    "and a 'ball' (ball_radius) to all digits",
    "hertz": "give 'parabola' with curvature_radius",
    "paraboloid": "give 'parabola' with curvature_radius",
    "flat": "a flat face needs no profile: leave it out",
    "annulus": "a hollow punch has punch.inner_radius",
    "hollow": "a hollow punch has punch.inner_radius",
    "fillet": "give 'rounded_rim' with flat_radius and curvature_radius",
    "conical": "give 'cone' with its slope",
}


def not_modelled(key: str) -> str | None:
    """Return what to do instead of a key that does not exist; None if nothing is known."""
    return next((told for word, told in WORDS.items() if word in key.lower()), None)


def kind_instead(given: object) -> str:
    """Return which kind of profile to give in place of one that does not exist."""
    kind = given.get("kind") if isinstance(given, Mapping) else None
    if (told := OTHER_KINDS.get(str(kind).lower())) is not None:
        return told
    near = difflib.get_close_matches(str(kind), KINDS_OF_PROFILES, 1)
    return f"there is no kind {kind!r}" + (f"; did you mean '{near[0]}'?" if near else "")
