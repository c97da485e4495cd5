"""What only engines have, in words of engines; the rooms around it know none.

new        a case of an own engine from a few lengths
step_mesh  its piston from a STEP file
truncation what the modes of its flexible bodies leave out of a run
verdicts   a finished run judged: film, pressure, cycle
"""
