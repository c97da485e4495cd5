"""The command line: `app` (what there is, exit codes), `common` (what several commands do), and a
file for each command.
"""
