"""`python -m rigrunner`: the same as the command `rigrunner`."""

import sys

from rigrunner.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
