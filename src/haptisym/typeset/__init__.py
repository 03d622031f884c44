"""Formulas as boxes, and boxes as plain text and MathML."""
