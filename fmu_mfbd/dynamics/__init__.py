"""Motion.

slider_crank       rigid crank and rod (K)
piston_motion      the piston's equations of motion
quasi_static       modes too fast for the step
instant            all of it at one instant, compiled
floating_frame     a flexible body in its frame
pin_friction       between piston and pin
generalised_alpha  time integration
first_steps        how it begins
impact             what it may remember of a step that stopped the piston
energy             what a step gave the bodies
account            what they took from the film over it
model              one step after the other
floating_pin       equations of motion of a pin on films of its own (K, D)
elimination        small systems of linear equations (N)
pin_instant        all of it at one instant with a floating pin, compiled
pin_model          the model with them
motion_in_space    equations of motion of a rigid piston out of the plane as well (K, D)
space_model        the model with them
bore_from_outside  a bore that deflects as another participant says (H)
monoblock          a flexible block of several cylinders on its mounts (U)
tables             gas pressure, measured profiles
speed_table        crank speed given (I)
start_state        start where another run stood
parameters         what a user may set
build_options      what is decided when the FMU is built
assembly           from bodies and parameters to the model
"""
