"""What is made of results files.

file            a results file, read
pictures        curves, maps, sections
sweep_pictures  of sweeps
compare         curves scored against one another
judgement       windows, work in loops
report          one HTML page
charts          what it draws besides fields, as data
solids          bodies on their meshes, for it
packing         its numbers, as text
rivals          rival models of one role side by side
fields_export   recorded fields as CSV, HDF5, VTU
"""
