"""Does it shake: imposed motion, a hand that holds the display, and every passive hand."""
