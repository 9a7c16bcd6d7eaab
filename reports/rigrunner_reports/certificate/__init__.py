"""Certificates as HTML and PDF: fixed texts by language, templates, one figure."""
