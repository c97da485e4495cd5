"""Common parts of laws, solvers and balance.

grid          cells and edges
quantities    names of the quantities of flow and shear that depend on the film thickness
faults        why a step is rejected
declaration   parameters with unit, range and description
"""
