"""What holds for all values of parameters that are known as ranges."""
