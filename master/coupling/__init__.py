"""Macro steps of a system of participants.

wiring         participants, wires in SI
starting       how participants start together, start loops
interface      all wires as one vector
stepping       predict, solve, halve (equations S)
step_control   lengths of macro steps by local error
methods        ways to the fixed point (Q)
work           work that crosses the wires, on both sides (W)
ledger         energy that participants took from one another (W2)
negotiation    whose own derivatives are those of a step
freezing       everything a further step depends on, as bytes
coupled        a whole system as one slave
native         the same as machine code: its entries, made of native_stepping, native_newton and
               native_system; native_block lays out their memory, native_given that of a case
"""
