"""A sealed run as one file, to be sent or put away: a ZIP with a manifest and digests."""
