"""Lubrication of piston skirts and journal bearings on a film grid.

Transient Reynolds equation, cavitation, asperity contact and friction. Kernels are pure functions
on arrays, each file with its numbered equations:

common      the grid, names of a film's quantities, faults
laws        viscosity, cavitation, contact, friction, roughness, coating
solvers     direct solvers of linear systems of the film
balance     the film balance on its grid, and one time step of the film

A step of a whole film:

constants   constants during a run
step        the order of a step, for skirts and bearings
step_parts  begin, forces and sums of a step; step_tangent: its derivatives
summary     scalars of a film in one pass over its cells
contradictions: between parameters

In Python: parameters, surroundings, model (`advance` and `tangent`), journal (under a load), alone
(`piston_cosim.Film`), bearing (`piston_cosim.bearing`) and its picture.
The FMU: variables, slave, build, preview. Without Python: native (memory and entries).
"""
