"""Lubrication: transient Reynolds equation, cavitation, asperity contact and friction on a skirt grid."""
