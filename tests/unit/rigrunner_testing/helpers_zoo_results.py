"""An analysis that keeps to everything, and one broken in one way for each check of the kit."""

from __future__ import annotations

from dataclasses import replace

from rigrunner.api.analysis import Requirements
