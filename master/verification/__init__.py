"""Proof.

rows           figures of every part beside their references
coupling       those of the master
importers      independent importers, each in a process of its own
"""
