"""Offline: a small exact body.

reduce         a mesh and a material in, a body out
reduced_body   the body as its file holds it
store          bodies kept by content: found without the code that reduces
rigid          a data sheet in, a body without modes out (J)
bases          which shapes a body keeps (J)
smooth_prior   modes from the pressures that a film is expected to have (J)
training       modes from the film forces of a run (J)
geometry       whether a mesh lies as it should (M)
symmetry       modes even or odd about two planes (J)
interpolation  from nodes to the film's grid (I)
bosses         pin bosses as film surfaces (I, J)
small_end      a rod's eye as a film surface, which yields (J)
film_loads     what a film did to the bodies in a finished run (J)
truncation     what a basis leaves out at such loads (J)
mode_tables    modes, shapes, recovered fields (J)
mode_pictures  modes as pictures
"""
