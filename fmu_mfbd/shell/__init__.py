"""Elastic shell of a bearing as a separate FMU, the package `fmu_mfbd.shell`.

Reduction and equations are in `reduction.shell` and `dynamics.bearing_shell`.
"""
