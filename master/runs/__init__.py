"""Runs.

run         one run, start to end
repetition  periods of a run, until one repeats the one before
extrapolation  what is slow from period to period
recorder    the results file, written
logs        convergence, step by step
console     progress and summary on the screen
live        a page with curves, to pause and to stop
checkpoint  stop and go on with the same bits
sweep       a case over values of its keys
studies     a case over settings, against the finest
"""
