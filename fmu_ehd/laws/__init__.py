"""Laws of a film.

piezoviscosity   viscosity by pressure (O)
cavitation       cavitation models and the active set (C)
roughness        average flow factors (R)
asperity         Greenwood-Tripp contact (A); contact: its mean over a cell
friction         shear forces and power (F); circumferential: those around a bearing
coating          soft layer (L)
hermite          tables of functions
"""
