"""`python -m master`: the same as `piston-cosim`."""

from .cli import main

main()
