"""Meshes of the quarter disc that gmsh makes: triangles, and quadrilaterals in geometric layers."""
