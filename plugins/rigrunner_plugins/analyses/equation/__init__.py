"""The analysis `equation`: a measurement model written in the procedure."""
