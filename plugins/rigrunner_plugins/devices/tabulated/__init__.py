"""A device that returns the values of a table, of a publication or another laboratory."""
