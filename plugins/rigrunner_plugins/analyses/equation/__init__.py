"""The analysis `equation`: a measurement model that a procedure writes down."""
