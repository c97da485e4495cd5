"""Skirt and bore as the film sees them.

film         thickness, sliding, forces back
surfaces     several films of a body in one block of numbers
pin          films of a pin in its shells
pin_shapes   tilt and bending of that pin (J)
space        shift along the pin, roll and yaw
profile      machined, measured, heated shapes (I)
grid         cell centres on the developed skirt
modal_field  modal displacement on a grid
arrays       shapes of arrays in named tuples
"""
