"""How the panel and the processes that work for it talk: what passes, and on what way."""
