"""A laboratory's documents: issued, amended and signed."""
