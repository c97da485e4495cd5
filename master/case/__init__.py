"""A case, from its file to a system that can run.

schema    what a case file may say, checked
keys      every key of it, those of the FMUs included, as a list and as a JSON schema
changes   keys set, dotted or short
check     a case looked at before anything is built
system    participants opened, wires checked
contract  an FMU against the interface contract, and in another's place
ssp       a case as a System Structure package, out and in
export    one FMU of a whole case
"""
