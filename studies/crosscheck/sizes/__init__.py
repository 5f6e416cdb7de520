"""Element sizes, polynomial degrees and time steps for a requested tolerance.

Where each one is chosen:

- element sizes at ring edges and at the rim: `ring_edges.edge_sizes`
- polynomial degree of the pressure: `degrees.pressure_degree`, `degrees.degree_of_modes`
- radial mesh of dimensionality reduction and boundary elements: `defaults.mdr_sizes`
- quadrilaterals and triangles of the finite elements: `defaults.quad_sizes`,
  `defaults.triangle_sizes`; elements of a low degree: `low_degrees.low_degree_quad_sizes`
- mesher, and the coarser mesh of the error estimate: `half_space_mesh`
- cells under a contact whose edges move: `cells.cells_of`
- far field: `defaults.pole_orders`; layered ground: `layers`
- number of time steps: `marching`, `defaults.grid_step`
- one discretisation for several problems: `shared.covering`
"""
