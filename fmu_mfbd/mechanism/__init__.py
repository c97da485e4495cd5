"""Open chains of rigid and reduced bodies: motion, residual and exact tangent of any of them.

chain      bodies, joints and force elements as tables
motion     motion of all bodies, from the block outwards (K)
inertia    forces that this motion needs (D)
equations  residual, tangent and its solution (D)

The FMUs still use the equations in `dynamics`. The tests hold both to the same numbers.
"""
