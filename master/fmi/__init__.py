"""Both ends of the FMI standard, and what every FMU carries of it.

slave         the slave every FMU is made of
variables     one declaration a variable
description   modelDescription.xml, 2.0 (and 3: 3.0)
documentation the page and the licences that an FMU carries
builder       FMUs from parts, cached by content
builder_native  FMUs that need no Python, by native_code (machine code) of native_parts
compiler      the C front in front/
tree          the project, or its copy in an FMU
requirements  what an FMU needs of Python
fields        scalars of an FMU gathered to arrays
quantities    units, at the edge alone
errors        bad input, discard, fault
checks        computed figures beside what they should be
compiled      how kernels are compiled; callees: those in the code of others; kernel_cache: kept
block         what machine code keeps between calls: trees of named tuples in rows of numbers
noted         faults that kernels note by number, and their sentences
cache         where the user's cache lies
"""
