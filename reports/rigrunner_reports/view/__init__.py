"""What the template shows, as texts: every number is rounded and every word chosen here."""
