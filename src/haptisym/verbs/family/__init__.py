"""Several environments behind one device: the worst case, and which environment binds."""
