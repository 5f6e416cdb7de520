"""Meshes by a gmsh that cannot be loaded are refused with the remedy."""

import sys

import pytest

from ringwear import MeshError, SizeField
from ringwear.meshes.by_gmsh import triangles


def test_meshes_by_a_gmsh_without_its_libraries_are_refused_with_the_remedy(tmp_path, monkeypatch):
    reason = "libGL.so.1: cannot open shared object file"
    (tmp_path / "gmsh.py").write_text(f'raise OSError("{reason}")', "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
    with pytest.raises(MeshError, match=r"libGL.*apt-get install.* libglu1-mesa"):
        triangles.mesh(SizeField((0.0, 1.0), 1e-2, 1e-2, 0.6, 5.0))
