"""Open chains of rigid and reduced bodies: motion, residual and exact tangent of any of them.

chain      bodies, joints and force elements as tables
motion     motion of all bodies, from the block outwards (K)
inertia    forces that this motion needs (D)
loads      loads from forces that turn with a body (D)
equations  residual and tangent (D)
solution   accelerations that fulfil the equations (N)
tied_pin   the chain of a piston on a tied pin, rod and crank
cylinder   the chain of a piston with its floating pin, rod and crank (K)
"""
