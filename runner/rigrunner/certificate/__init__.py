"""The content of certificates, from a stored run and its result, and the letterhead."""
