"""A flexible block of several cylinders as an FMU of its own, the package `fmu_mfbd.monoblock` of a
case. Reduction and equations stand in `reduction.monoblock` and `dynamics.monoblock`.
"""
