"""Direct solvers of the linear systems of a film.

blocks    block-tridiagonal elimination (B)
sparse    sparse solvers, and the choice among all
"""
