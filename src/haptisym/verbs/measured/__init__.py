"""Measured responses, judged line by line: exceeds, below or unresolved."""
