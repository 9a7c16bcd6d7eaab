"""From entry points and drop-in files to typed look-ups of plugins."""

from rigrunner.registry.culprit import culprit
from rigrunner.registry.loading import HOOK_OF_KIND, load_registry, with_drop_ins
from rigrunner.registry.lookup import DisabledPlugin, Plugin, Provider, Registry

__all__ = [
    "HOOK_OF_KIND",
    "DisabledPlugin",
    "Plugin",
    "Provider",
    "Registry",
    "culprit",
    "load_registry",
    "with_drop_ins",
]
