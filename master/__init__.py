"""Coupling: an FMI co-simulation master that iterates every macro step to a fixed point. It knows
participants and signals, neither films nor bodies. Its rooms, each built on those below it:

    commands      the command line, a file a command
    runs          a run from start to end, and many of them: sweeps, studies
    engine        what only engines have: a new case from bore and stroke, verdicts on a run
    results       what is made of results files: reports, pictures, tables, comparisons
    case          a case, from its file to participants and wires; SSP; the contract
    coupling      macro steps and the methods that bring them to agreement
    participants  one FMU under the master, in whatever way it can take part
    fmi           what both ends of the standard share: variables, slaves, building FMUs
"""
