"""Which values of one to three parameters make the bandwidth largest."""
