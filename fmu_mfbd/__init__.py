"""Flexible bodies: piston and cylinder block reduced from finite elements, on a rigid slider-crank."""
