"""The verdict: the statement of conformity in every document, from evidence, limits and rule."""
