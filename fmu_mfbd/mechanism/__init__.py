"""Open chains of rigid and reduced bodies: motion, equations and tangent of any of them."""
