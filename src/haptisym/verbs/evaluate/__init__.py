"""The two-step evaluation of a scene, of which what does not matter may be left out."""
