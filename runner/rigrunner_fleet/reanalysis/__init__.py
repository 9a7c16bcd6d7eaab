"""Analyse many stored runs again, each once: on all cores or a cluster, and resumable."""
