"""Records the numbers of the guard again: `PYTHONPATH=tests python -m guard`.

The changes are printed. Commit the file alone, with the reason for each change in the message.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

from guard.numbers import differences
from guard.rigs import SEEDS
from guard.runs import RECORDED, SHIPPED, faulty_rig, shipped


def main() -> None:
    """Run everything, print the changes, and write the file."""
    before = json.loads(RECORDED.read_text(encoding="utf-8")) if RECORDED.exists() else {}
    now = {}
    for name in (*SHIPPED, *SEEDS):
        with tempfile.TemporaryDirectory() as folder:
            run = faulty_rig if isinstance(name, int) else shipped
            now[str(name)] = run(name, Path(folder))
        for text in differences(before.get(str(name), {}), now[str(name)]) if before else ():
            sys.stdout.write(f"{name}: {text}\n")
    text = json.dumps(now, ensure_ascii=False, indent=0, allow_nan=False)
    RECORDED.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
