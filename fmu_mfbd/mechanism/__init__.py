"""Open chains of rigid and reduced bodies: motion, residual and exact tangent of any of them.

chain      bodies, joints and force elements as tables
motion     motion of all bodies, from the block outwards (K)
inertia    forces that this motion needs (D)
equations  residual and tangent (D)
solution   accelerations that fulfil the equations (N)
tied_pin   crank, rod and piston as a chain

The FMUs use a chain for a tied pin, and equations in `dynamics` for a floating pin. The tests hold
both to the same numbers.
"""
