"""`python -m tests.benchmarks`: see `--help`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))  # as pytest does, for the helpers

from benchmarks.command import main

if __name__ == "__main__":
    sys.exit(main())
