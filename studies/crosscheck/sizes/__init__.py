"""Element sizes and polynomial degrees for a requested tolerance.

Where each one is chosen:

- element sizes at ring edges and at the rim: `ring_edges.edge_sizes`
- polynomial degree of the pressure: `degrees.pressure_degree`, `degrees.degree_of_modes`
- radial mesh of dimensionality reduction and boundary elements: `radial.radial_sizes`
- mesher, mesh and degree of the finite elements, those of the error estimate, and the far field:
  `finite_elements.fem_sizes`; sizes of quadrilaterals: `quads`, of triangles: `triangles`
- cells under a contact whose edges move: `cells.cells_of`
- layered ground: `layers`
- one discretisation for several problems: `shared.covering`
"""
