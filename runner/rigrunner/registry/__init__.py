"""Typed look-up of plugins from entry points and drop-in files."""

from rigrunner.registry.culprit import culprit, whereabouts
from rigrunner.registry.loading import load_registry, with_drop_ins
from rigrunner.registry.lookup import DisabledPlugin, Plugin, Provider, Registry
from rigrunner.registry.methods import call_problem, place_of

__all__ = [
    "DisabledPlugin",
    "Plugin",
    "Provider",
    "Registry",
    "call_problem",
    "culprit",
    "load_registry",
    "place_of",
    "whereabouts",
    "with_drop_ins",
]
