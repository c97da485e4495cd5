"""One FMU under the master: fields, steps, saved states, derivatives.

participant   what the master asks of each
open          an FMU of either version
fmi2, fmi3    FMI 2.0 and 3.0 by FMPy
pointers      as compiled code calls them
local         a slave of this process, without FMI
clocks        an FMI 3.0 FMU whose clocks tick (P7, P8)
isolated      in a process of its own
remote        on a worker of a Dask cluster
interpolated  inputs that move inside a step
substeps      a step of its own, several to a macro step
table         a CSV file of signals
printf        log messages with their arguments
plugins       what other installed packages bring
derivatives   by differences; trial of what an FMU offers (P1)
rollback      trial of saving and restoring
"""
