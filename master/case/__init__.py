"""A case, from its file to a system that can run.

schema     what a case file may say, checked            ssp        a case as a System Structure
package, out and in system     participants opened, wires checked           contract   an FMU
against the interface contract, and in another's place export     one FMU of a whole case
"""
