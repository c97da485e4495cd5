"""The command line.

`app` lists the commands and sets exit codes. `common` holds what several commands use. Each command
is a file; the folders `results` and `fmu` hold the commands of these groups.
"""
