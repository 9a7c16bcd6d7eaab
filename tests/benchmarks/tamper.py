"""Changes 200 single bytes of a run file and its certificate, and verifies each.

The run is that of the shipped procedure, with five set-points and twelve cycles each.

`python tests/benchmarks/tamper.py [COUNT [SEED]]` prints the table of docs/evidence/forgeries.md.
"""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from e2e.helpers_tamper import Flip, flips, issue, letterhead, quick_runs

COUNT, SEED = 200, 17025
PLACES = {
    "a section, line or object of the document": "changed at bytes",
    "the document's seal": "the seal itself",
    "an object of the run file": "/entry",
    "the run file's root": "/ (file)",
    "its structure, which cannot be walked through": "structure",
    "its layout, nothing recorded": "layout of",
}


def named_place(flip: Flip) -> str:
    text = " ".join(flip.differences)
    return next((name for name, part in PLACES.items() if part in text), "nowhere")


def main(count: int = COUNT, seed: int = SEED) -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run_folder = quick_runs(folder)
        files = issue(run_folder, letterhead(folder / "lab"), folder / "out")
        all_flips = []
        for index, flip in enumerate(flips(files, run_folder, folder / "scratch", count, seed), 1):
            all_flips.append(flip)
            sys.stderr.write(f"\r{index} of {count}")
            sys.stderr.flush()
    sys.stderr.write("\n")
    write_table(all_flips)
    for flip in all_flips:
        if not (flip.found and flip.placed):
            sys.stdout.write(f"MISSED {flip}\n")
    return sum(not (flip.found and flip.placed) for flip in all_flips)


def write_table(all_flips: list[Flip]) -> None:
    sys.stdout.write("| file | changed | found | said where | as |\n|---|---:|---:|---:|---|\n")
    for name in dict.fromkeys(flip.file for flip in all_flips):
        of_file = [flip for flip in all_flips if flip.file == name]
        places = Counter(named_place(flip) for flip in of_file).most_common()
        cell = "; ".join(f"{place}: {count}" for place, count in places)
        found, placed = sum(flip.found for flip in of_file), sum(flip.placed for flip in of_file)
        form = "run.h5" if name == "run.h5" else Path(name).suffix.removeprefix(".").upper()
        sys.stdout.write(f"| {form} | {len(of_file)} | {found} | {placed} | {cell} |\n")


if __name__ == "__main__":
    sys.exit(main(*(int(argument) for argument in sys.argv[1:])) > 0)
