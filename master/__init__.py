"""Coupling: an FMI co-simulation master that iterates every macro step to a fixed point.

It knows participants and signals, neither films nor bodies. Its packages, each built on those below
it:

    commands      the command line, a file for each command
    runs          runs, sweeps and studies
    engine        parts that only engines have: a new case from bore and stroke, checks of a run
    results       products of results files: reports, pictures, tables, comparisons
    case          a case, from its file to participants and wires; SSP; the contract
    coupling      macro steps, and the methods that iterate them
    participants  one FMU under the master, in all forms
    fmi           common parts of both ends of the standard: variables, model classes, FMUs
"""
