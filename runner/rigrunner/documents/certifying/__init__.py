"""Issue, amend, withdraw and sign the documents of a laboratory."""
