"""Issue, amend and sign the documents of a laboratory."""
