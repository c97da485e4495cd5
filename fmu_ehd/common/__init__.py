"""What laws, solvers and balance share.

grid          cells and edges
quantities    names of what a film thickness means for flow and shear
faults        why a step is rejected
declaration   parameters with unit, range and description
"""
