"""The commands `piston-cosim fmu`, one file each."""
