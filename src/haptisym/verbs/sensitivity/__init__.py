"""How crossings, changeovers and the bandwidth move with each parameter."""
