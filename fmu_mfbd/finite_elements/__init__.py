"""Meshes and matrices.

mesh           reading, named surfaces, faults
regions        surfaces that the file does not name
point_cloud    nodes without elements
element        ten-node tetrahedron by scikit-fem (M)
faces          triangles and pressure on them (M)
matrices       stiffness and mass of another program (M)
solver         sparse direct solvers, answers kept on disk
"""
