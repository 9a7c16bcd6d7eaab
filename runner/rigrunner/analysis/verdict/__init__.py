"""The verdict: evidence, limits and rule give what every document says of conformity."""
