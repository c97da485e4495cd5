"""Verification cases: computed figures with their references.

rows           figures of every part
film           closed forms, tables and orders of the film; bearings; motored, a moving skirt
bodies         reduced bodies and mechanism; exudyn, the independent multibody code
coupling       master
coupled        coupled runs against monolithic, one independent system of equations
importers      independent FMI importers, each in a process of its own
"""
