"""What only engines have, in words of engines; the rooms around it know none.

new        a case of an own engine from a few lengths
step_mesh  its piston from a STEP file; piston_mesh: one of our own, slipper or full
answer     what a run answers: its headlines and its verdicts
headlines  film, pressure, friction, side force, slap, oil: ten lines
impacts    energy that a piston loses where it strikes the bore, and the edge that strikes
oil_balance  oil that passes the edges of a film in a period
verdicts   what is amber or red
truncation what the modes of its flexible bodies leave out of a run
places     where a film has its worst place, by side, angle and height
sections   what a report of a piston shows beyond the case's pictures
"""
