"""A scene simulated in time from its equations of motion: the witness for every closed form."""
