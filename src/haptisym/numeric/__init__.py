"""Closed forms as functions of arrays: one straight-line program in floats, double-doubles and balls."""
