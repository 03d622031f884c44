"""Documents and formulas as values, and their writers: plain text, MathML, LaTeX, HTML, code."""
