"""Bearings of experiments and published studies: inputs and the figures that they give."""
