"""The commands `piston-cosim results`, one file each."""
