"""Both ends of the FMI standard, and the code that every FMU contains.

slave           base class of model classes, the implementations of FMUs
variables       declaration of variables
description     modelDescription.xml of FMI 2.0 (description3: of FMI 3.0)
documentation   page and licences inside an FMU
builder         FMUs from parts, cached by content
builder_native  FMUs that need no Python, from native_code (machine code) of native_parts
model_file      the file of a native FMU that describes its model
compiler        C compilers by platform, for the front in front/
tree            the project, or its copy in an FMU
requirements    requirements of an FMU on Python
fields          scalars of an FMU gathered into arrays
quantities      conversion of units
errors          bad input, discarded steps, faults
compiled        compilation of kernels (callees: kernels inside others; kernel_cache: their cache)
block           memory of machine code: trees of named tuples as rows of numbers
noted           faults that kernels note by number, and their sentences
cache           the user's cache folder
"""
