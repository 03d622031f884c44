"""Exact numbers, polynomials and real functions with certified zeros: mathematics that knows no haptics."""
