"""Inverse design: the exact set of values of a parameter for which a display is transparent on its
whole band."""
