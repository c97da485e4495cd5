"""Lubrication: transient Reynolds equation, cavitation, asperity contact and friction on a skirt grid.

Kernels, pure functions on arrays, each file with its numbered equations:

    grid         cells and edges                          reynolds   film balance on faces and cells (E), its stencils
    films        what a film means for flow and shear (E) cavitation cavitation models and the active set (C)
    roughness    average flow factors (R)                 blocks     block-tridiagonal solver (B)
    asperity     Greenwood-Tripp contact (A)              sparse     sparse solvers, and the choice among all
    oil          viscosity laws (O)                       friction   shear forces and power (F)
    coating      soft layer (L)                           summary    scalars of a film in one pass
    hermite      tables                                   compiled   how kernels are compiled

What composes them: film_step (one step of the balance and its tangent), parameters, surroundings, model (everything, with
`advance` and `tangent`). The FMU: variables, slave, build. Proof: verification (V), on films of its own and of motored.
"""
