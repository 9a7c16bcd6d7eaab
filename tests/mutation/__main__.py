"""`python -m tests.mutation`: see `--help`."""

import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: a child has one thread
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))  # as pytest does, for the helpers

from mutation.command import main

if __name__ == "__main__":
    sys.exit(main())
