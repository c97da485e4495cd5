"""Coupling: an FMI co-simulation master that iterates every macro step to a fixed point."""
