"""One package a verb, its entry in the module ``entry``: mathematics only."""
