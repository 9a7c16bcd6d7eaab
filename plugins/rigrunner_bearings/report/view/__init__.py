"""The content of the templates as texts: every number is rounded and every word chosen here."""
