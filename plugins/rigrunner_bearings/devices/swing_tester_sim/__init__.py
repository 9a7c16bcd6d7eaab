"""A swing friction tester in closed form: its periodic steady state, exact and fast."""
