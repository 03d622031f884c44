"""Formulas as code in other languages."""
