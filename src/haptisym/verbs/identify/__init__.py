"""A parametric model fitted to a measured response, on request, with what the lines tell of each
parameter."""
