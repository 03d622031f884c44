"""Formulas, results and documents in LaTeX."""
