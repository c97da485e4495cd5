"""A case, from its file to a system that can run.

tables        common parts of all tables of a case file
schema        the tables and their checks; shown: those of pictures and axes
keys          every key of a case and of its FMUs, as a list and as a JSON schema
reading       search and reading of case files
changes       changes of keys, dotted or short
checked       a case from its TOML tree, with every fault
ahead         faults that are found before anything is built
symmetry      symmetry of films and bodies about the thrust plane
times         start, stop and macro step
values        parameters with units as numbers
wires         ends, units and tolerances of wires
inputs        interpolated inputs, and what they need of FMUs
opening       FMUs that are built or opened, tables and plugins
system        the complete system, ready to run
check         results of `piston-cosim check`
contract      checks of an FMU by the interface contract, and replacement by other FMUs
ssp           export and import of a case as a System Structure package
export        one FMU of a whole case
given         build options that one participant takes from another
machine_code  participants that run as machine code
"""
