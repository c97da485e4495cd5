"""Laws of a film.

oil              viscosity by temperature and shear rate (O); piezoviscosity: by pressure
cavitation       cavitation models and the active set (C)
roughness        average flow factors (R)
asperity         Greenwood-Tripp contact (A); contact: its mean over a cell
friction         shear forces and power (F); circumferential: those around a bearing
coating          soft layer (L)
hermite          tables of functions
"""
