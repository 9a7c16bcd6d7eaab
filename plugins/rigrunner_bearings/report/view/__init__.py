"""What its templates show, as texts: every number is rounded and every word chosen here."""
