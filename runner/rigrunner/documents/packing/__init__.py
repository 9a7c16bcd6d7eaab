"""A sealed run as one file for transport: a ZIP with a manifest and digests."""
