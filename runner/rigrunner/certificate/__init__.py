"""From a stored run and its result to the content of a certificate; the laboratory's own part."""
