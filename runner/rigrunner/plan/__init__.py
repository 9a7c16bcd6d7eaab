"""From procedure and station to explicit steps."""
