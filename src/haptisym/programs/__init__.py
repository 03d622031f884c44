"""One straight-line program of a chain, and every arithmetic that runs it: floats, double-doubles,
balls, Taylor models."""
