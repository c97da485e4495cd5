"""One FMU under the master: fields, steps, saved states, derivatives.

participant   protocol of participants
open          an FMU of either version
fmi2, fmi3    FMI 2.0 and 3.0 by FMPy
description   content of an FMU's model description, cached
transfer      values of an FMU's fields, set and read
local         a model class in this process, without FMI
clocks        an FMI 3.0 FMU with clocks (P7, P8)
isolated      in a separate process
interpolated  inputs that vary during a step
substeps      several steps within a macro step
table         a CSV file of signals
printf        log messages with their arguments
plugins       entry points of other installed packages
derivatives   by differences; check of the FMU's own (P1)
rollback      check of saving and restoring
"""
