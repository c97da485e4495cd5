"""Reduction of bodies before a run.

reduce         mesh and material to a reduced body
reduced_body   contents of a reduced body's file
store          cache of reduced bodies by content
frame_integrals inertia in planar motion (J)
rigid          data sheet to a body without modes (J)
bases          reduction bases (J)
smooth_prior   modes from the expected pressures of a film (J)
training       modes from the film forces of a run (J)
geometry       checks of a mesh's position (M)
symmetry       modes even or odd about two planes (J)
interpolation  from nodes to the film's grid (I)
bosses         pin bosses as film surfaces (I, J)
shell          elastic shell of a bearing as a film surface (J)
film_loads     film forces of a finished run (J)
truncation     truncation error of a basis at such loads (J)
mode_tables    modes, shapes, recovered fields (J)
mode_pictures  pictures of modes
"""
