"""Equations of motion of the bodies, their time integration, and the model of the FMU.

system             bodies, mechanism and films together
skirt_films        all films of the skirt
instant            motion, forces and films at one instant, compiled
response           derivatives of an instant
first_steps        time integration at the start
energy             energy of the bodies over a step
account            energy from the film over a step
state              state at the start of a step
step               a step and its derivatives, for both FMUs
model              the model, which takes one step after the other
pin_shells         position of a floating pin in its shells
pin_films          all films of pin and crank
pin_axis           a pin that tilts and bends in its films
pin_outputs        scalar outputs of a floating pin and of films of the crank
motion_in_space    equations of motion of a rigid piston out of the plane as well (K, D)
space_model        model with these equations
bore_from_outside  a bore whose deflection comes from another participant (H)
bearing_shell      an elastic shell of a bearing (D)
monoblock          a flexible block of several cylinders on its mounts (U)
tables             gas pressure, measured profiles
speed_table        crank speed as a table (I)
start_state        start from the state of another run
parameters         parameters of the FMU
build_options      options of the build
element_laws       force elements for these parameters
assembly           model of given bodies and parameters
"""
