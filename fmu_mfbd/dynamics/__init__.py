"""Motion.

slider_crank       rigid crank and rod (K)               floating_frame     a flexible body in its frame
piston_motion      the piston's equations of motion      pin_friction       between piston and pin
quasi_static       modes too fast for the step           generalised_alpha  time integration
instant            all of it at one instant, compiled    model              one step after the other
tables             gas pressure, measured profiles       speed_table        crank speed given
start_state        start where another run stood         assembly           from body and parameters to the model
"""
