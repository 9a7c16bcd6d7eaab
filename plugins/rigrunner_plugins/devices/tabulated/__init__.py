"""A device that gives the values of a table: a publication's, or another laboratory's."""
