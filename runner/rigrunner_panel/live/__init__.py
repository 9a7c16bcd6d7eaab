"""What is known of a job that goes on: its story, its curves, and the analysis so far."""
