"""A case, from its file to a system that can run.

tables        what all tables of a case file share
schema        the tables, checked; shown: those of pictures and axes
keys          every key of a case, those of the FMUs included, as a list and as a JSON schema
reading       find a case file and read it
changes       set keys, dotted or short
checked       a case from its TOML tree, with every fault
ahead         faults that show before anything is built
times         start, stop and macro step
values        parameters with units as numbers
wires         ends, units and tolerances of wires
inputs        interpolated inputs, and what they need of FMUs
opening       FMUs that are built or opened, tables and plugins
system        the whole, ready to run
check         what `piston-cosim check` shows
contract      an FMU against the interface contract, and in another's place
ssp           a case as a System Structure package, out and in
export        one FMU of a whole case
given         build options that one participant takes from another
machine_code  participants that run as machine code
"""
