"""Formulas as boxes, and their writers: plain text, MathML, LaTeX, HTML, code."""
