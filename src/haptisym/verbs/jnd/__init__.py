"""Thresholds from a person's answers: what a table of them says of the just-noticeable
difference."""
