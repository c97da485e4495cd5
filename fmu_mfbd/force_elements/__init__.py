"""Forces between two bodies that depend on their motion, one file each.

A new one needs its file and its entry in `FORCE_ELEMENTS`. Its parameters, its tangent and its
power follow from that, in Python and in native FMUs. So do the coordinates of a joint that it
frees.

element       declaration of a force element
land_contact  contact of the top land with the bore (D)
"""

from .land_contact import LAND_CONTACT

FORCE_ELEMENTS = (LAND_CONTACT,)

SLIDES = {name: one for one in FORCE_ELEMENTS for name in one.frees}
"""Displacement in a joint -> the element that frees it, for the build option `slides`."""
