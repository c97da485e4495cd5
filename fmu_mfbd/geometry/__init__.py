"""Geometry of films between skirt and bore, and between pin and shells.

film         thickness, sliding velocity, forces
surfaces     several films of a body in one array
pin          films of a pin in its shells
pin_shapes   tilt and bending of that pin (J)
space        shift along the pin, roll and yaw
profile      machined, measured and thermal shapes (I)
grid         cell centres on the developed skirt
modal_field  modal displacement on a grid
arrays       shapes of arrays in named tuples
"""
