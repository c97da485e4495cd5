"""The command line.

`app` lists the commands and sets exit codes. `common` contains functions of several commands.
Each command is a file. The folders `results` and `fmu` contain the commands of these groups.
"""
