"""A scene simulated in time from its equations of motion: an independent check of the closed
forms."""
