"""Runs: from the start of a system to its results.

run            one run
repetition     periods of a run, until one repeats the previous one
extrapolation  slow members of the state, extrapolated from period to period
recorder       writing of the results file
logs           tables of convergence
console        progress and summary on the screen
checkpoint     stop and resume with the same results
sweep          runs over values of keys
studies        runs over settings, compared with a reference
"""
