"""`python -m piston_cosim`: the same as `piston-cosim`."""

from .master.commands.app import main

main()
