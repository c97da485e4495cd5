"""Open chains of rigid and reduced bodies: motion, residual and exact tangent of any of them.

chain        bodies, joints and force elements as tables
translations how each joint moves its body: play, slider, guide (K, D)
angles       how the angle of each body follows: one branch for each kind (K, D)
motion       motion of all bodies, from the block outwards (K)
inertia      forces that this motion needs (D)
loads        loads from forces that turn with a body (D)
laws         forces that depend on the motion of two bodies, and their derivative (D)
equations    residual (D)
derivative   its tangent (D)
solution     accelerations that fulfil the equations (N)
cylinder     the chain of a piston with its pin, tied or floating, rod and crank (K)
slider_crank       rigid crank and rod (K)
floating_frame     integrals of a flexible body
carrier            acceleration of the block's frame (K)
generalised_alpha  time integration
bdf2               integration of a pin on films and of the modes that support it
impact             memory of a step that stopped the piston
modal_damping      springs and dampers of modes, and which have inertia (I)
pin_friction       between piston and pin
piston_motion      coordinates and load of the piston
elimination        small systems of linear equations (N)
"""
