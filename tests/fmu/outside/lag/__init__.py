"""Participant package with a native FMU that compiles in seconds: a first-order lag."""
