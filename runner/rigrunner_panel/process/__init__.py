"""Communication between the panel and its processes."""
