"""Offline: a small exact body.

reduce         a mesh and a material in, a body out      bases          which shapes a body keeps
interpolation  from nodes to the film's grid             symmetry       modes even or odd about two planes
mode_tables    modes, shapes, recovered fields           mode_pictures  modes as pictures
"""
