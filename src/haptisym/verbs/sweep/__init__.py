"""Whole design spaces: many parameter sets at once, counted with certainty in floats."""
