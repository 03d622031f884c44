"""Which effects of a scene matter, with proof, and what leaving out the others changes at most."""
