"""The numbers of a result document, for comparing two documents."""

from __future__ import annotations


def numbers(node, path=""):
    """Return every number in a document by its path."""
    if isinstance(node, dict):
        return {k: v for key in node for k, v in numbers(node[key], f"{path}.{key}").items()}
    if isinstance(node, list):
        return {k: v for i, x in enumerate(node) for k, v in numbers(x, f"{path}[{i}]").items()}
    return {path: node} if isinstance(node, (int, float)) and not isinstance(node, bool) else {}
