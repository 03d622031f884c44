"""Figures, after those of the paper: each function draws on the axes that it is given and changes
nothing else."""
