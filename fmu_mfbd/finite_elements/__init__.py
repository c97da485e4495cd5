"""Meshes and matrices.

mesh           reader, named surfaces, faults
regions        surfaces by geometry
ring           a ring without a mesh file
point_cloud    nodes without elements
element        ten-node tetrahedron by scikit-fem (M)
faces          triangles and pressure on them (M)
matrices       stiffness and mass of another program (M)
solver         sparse direct solvers, and a cache of their solutions
"""
