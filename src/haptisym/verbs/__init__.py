"""One package a verb: the mathematics of its question, asked in its module ``entry``."""
