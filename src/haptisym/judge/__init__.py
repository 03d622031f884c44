"""What a person notices: crossings, percepts, peaks, and the evaluation that holds them."""
