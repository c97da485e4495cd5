"""What `import piston_cosim` offers of the master: cases opened, changed and run; sweeps; bodies
reduced; own participants coupled; FMUs built and loaded.

The commands call the same functions: a case is opened by `case.system`, run by `runs.run`, swept by
`runs.sweep`.
"""
