"""Macro steps of a system of participants.

wiring         participants, wires in SI
starting       start of all participants, start loops
vector         vector of all wires: layout, step length, extrapolation; also compiled
interface      evaluation of all participants, and its derivative
stepping       predict, solve, halve (equations S)
step_control   lengths of macro steps by local error
methods        ways to the fixed point (Q); iteration and krylov are also compiled
work           work that crosses the wires, on both sides (W)
ledger         energy that participants receive from each other (W2)
negotiation    checks of saved states and derivatives
freezing       stepper as bytes
coupled        a system as one FMU
native         entries of that FMU as machine code, with native_system;
               native_block is their memory, native_given its content for a case
"""
