"""Functions of `import piston_cosim`: cases, sweeps, reduced bodies, own participants, FMUs.

The commands call the same functions. `case.system` opens a case, `runs.run` runs it, and
`runs.sweep` runs sweeps.
"""
