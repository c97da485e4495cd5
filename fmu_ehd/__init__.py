"""Lubrication of piston skirts and journal bearings on a film grid.

Transient Reynolds equation, cavitation, asperity contact and friction. Kernels are pure functions
on arrays, each file with its numbered equations:

oil         viscosity by temperature and shear rate (O)
laws        viscosity by pressure, cavitation, contact, friction, roughness, coating
balance     the film balance on its grid, and one time step of the film
solvers     direct solvers of its linear systems

A step of a whole film:

constants   constants during a run
step        the order of a step, for skirts and bearings
step_parts  begin, forces and sums of a step; step_tangent: its derivatives
summary     scalars of a film in one pass over its cells
faults      why a step is rejected; contradictions: between parameters

In Python: parameters, surroundings, model (`advance` and `tangent`), journal (under a load), alone
(`piston_cosim.Film`).
The FMU: variables, slave, build, preview. Without Python: native (memory and entries).
"""
