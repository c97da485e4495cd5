"""What only engines have, in words of engines; the rooms around it know none.

new        a case of an own engine from a few lengths
step_mesh  its piston from a STEP file
sections   what a report of a piston shows beyond the case's pictures
verdicts   a finished run judged: film, pressure, cycle
"""
