"""Motion.

system             bodies, mechanism and films together
skirt_films        all films of the skirt
instant            all of it at one instant, compiled
response           its derivative
first_steps        how it begins
energy             what a step gave the bodies
account            what they took from the film over it
state              what a step starts from
step               a step and its derivatives, for both FMUs
model              one step after the other
pin_shells         where a floating pin is in its shells
pin_films          all films of pin and crank
pin_axis           a pin that tilts and bends in its films
pin_outputs        scalar outputs of a floating pin and of films of the crank
motion_in_space    equations of motion of a rigid piston out of the plane as well (K, D)
space_model        the model with them
bore_from_outside  a bore that deflects as another participant says (H)
bearing_shell      an elastic shell of a bearing (D)
monoblock          a flexible block of several cylinders on its mounts (U)
tables             gas pressure, measured profiles
speed_table        crank speed given (I)
start_state        start where another run stood
parameters         what a user may set
build_options      what is decided when the FMU is built
element_laws       force elements for these parameters
assembly           from bodies and parameters to the model
"""
