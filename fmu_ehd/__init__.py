"""Lubrication of piston skirts and journal bearings on a film grid.

Transient Reynolds equation, cavitation, asperity contact and friction.

Kernels, pure functions on arrays, each file with its numbered equations:

    grid       cells and edges
    films      what a film means for flow and shear (E)
    cavitation cavitation models and the active set (C)
    roughness  average flow factors (R)
    asperity   Greenwood-Tripp contact (A)
    oil        viscosity laws (O)
    piezoviscosity viscosity by pressure (O)
    flow_film  films of any oil, smooth or rough
    coating    soft layer (L)
    hermite    tables
    reynolds   film balance on faces and cells (E), its stencils
    blocks     block-tridiagonal solver (B)
    sparse     sparse solvers, and the choice among all
    friction   shear forces and power (F)
    summary    scalars of a film in one pass
    storage    film content, second order in time (T)
    transport  sharp fronts of oil (T)
    oil_layer  oil on the bore (T)

What composes them, kernels too: film_step (one step of the balance and its tangent), coated_film
(the same under a coating), faults and contradictions (what is refused), step_parts (begin, forces,
sums and derivatives of a step); step puts all of them in order, for skirt and bearing. In Python:
parameters, surroundings, model (everything, with `advance` and `tangent`). The FMU: variables,
slave, build; without Python: native_step (what `step` needs, on one block), native (its entries).
"""
