"""Meshes and matrices.

mesh           reading, named surfaces, faults           element        ten-node tetrahedron by scikit-fem
faces          triangles and pressure on them            matrices       stiffness and mass of another program
point_cloud    nodes without elements                    solver         sparse direct solvers, answers kept on disk
"""
