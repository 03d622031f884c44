"""What is evaluated: scenes, their files and catalogue, the chain of effects, the distortion,
thresholds."""
