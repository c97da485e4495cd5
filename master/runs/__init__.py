"""Runs.

run            one run, start to end                     console        progress and summary on the
screen recorder       the results file, written                 checkpoint     stop and go on with
the same bits logs           convergence, step by step                 sweep          a case over
values of its keys studies        a case over settings, against the finest
"""
