"""Anchors read every kind of profile a second time, by formulas of their own."""

from ringwear.studies.crosscheck.anchors import reading
from ringwear.studies.crosscheck.problem.fields import KINDS, ProfileSection


def test_every_kind_of_profile_has_a_second_reading():
    kinds = {name for name, section in KINDS.items() if issubclass(section, ProfileSection)}
    assert kinds == reading.HEIGHTS.keys()
