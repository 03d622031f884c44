"""Exact numbers, functions of omega, certified zeros and charts of them: mathematics that knows no
haptics."""
