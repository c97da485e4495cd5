"""Parts that only engines have, in the terms of engines.

new          a new case of an engine from a few lengths
step_mesh    its piston from a STEP file; piston_mesh: a generated one, slipper or full skirt
answer       main results in ten lines, checks and uncertainties of a run
measures     table of the measures of a run, which all others read
friction     friction power, mean effective pressure and share of contact of all films
impacts      impacts of a piston on the bore: energy lost, and the edge that strikes
oil_balance  oil that passes the edges of a film in a period
uncertainty  parts of the uncertainty of a figure, the rule that combines them, and its text
indicator    estimate of these parts from one run
comparison   difference of the figures of two runs, and of their cases
verdicts     checks: pass, warning, fail
truncation   truncation error of the modes of flexible bodies
places       position of the extreme value of a film, by side, angle and height
sections     sections of a piston's report in addition to the case's pictures
"""
