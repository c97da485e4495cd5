"""Macro steps of a system of participants.

wiring         participants, wires in SI, their start    step_control   lengths of macro steps by local error
interface      all wires as one vector                   work           work that crosses the wires, on both sides (W)
stepping       predict, solve, halve                     freezing       everything a further step depends on, as bytes
methods        ways to the fixed point (C)               coupled        a whole system as one slave
"""
