"""Studies on random simulated rigs: what the checks and the uncertainties are worth."""
