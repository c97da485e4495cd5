"""Flexible block of several cylinders as a separate FMU, the package `fmu_mfbd.monoblock`.

Reduction and equations are in `reduction.monoblock` and `dynamics.monoblock`.
"""
