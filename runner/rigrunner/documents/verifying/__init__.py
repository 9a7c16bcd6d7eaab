"""Whether a run, and the documents made of it, are what they say they are."""
