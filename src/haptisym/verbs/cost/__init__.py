"""What accuracy costs in time, for a scene and for the hard cases."""
