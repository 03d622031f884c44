"""Does it shake: prescribed motion, a hand, and any passive operator."""
