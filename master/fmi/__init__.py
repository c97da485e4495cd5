"""Both ends of the FMI standard: variable tables, slaves, FMU building (what the FMUs carry) and FMU access."""
