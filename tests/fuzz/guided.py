"""Lets Atheris look for files that crash a reader: `python tests/fuzz/guided.py procedure`.

Coverage-guided, from the same good files as `fuzz.py`: it keeps what reaches new code and changes
that further. Needs the extra `fuzz` (Linux and macOS). Options of libFuzzer go behind the name,
such as `-max_total_time=600`. It ends at the first crash and keeps the file in `--out`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import atheris

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

with atheris.instrument_imports(include=["rigrunner", "rigrunner_plugins", "yaml"]):
    from targets import TARGETS

    from fuzz import GOOD, seeds_of, verdict


class ReaderCrashedError(Exception):
    """What libFuzzer is told."""


def main() -> None:
    """Fuzz one reader until it crashes or the time is over."""
    parser = argparse.ArgumentParser(description="Looks for files that crash a reader.")
    parser.add_argument("reader", choices=[each.name for each in TARGETS])
    parser.add_argument("--out", type=Path, default=Path("fuzz-crashes"))
    given, options = parser.parse_known_args()
    target = next(each for each in TARGETS if each.name == given.reader)
    given.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as corpus, tempfile.TemporaryDirectory() as folder:
        for number, seed in enumerate(seeds_of(target)):
            (Path(corpus) / f"seed{number}").write_bytes(seed)

        def one(data: bytes) -> None:
            outcome, where = verdict(target, data, Path(folder))
            if outcome not in GOOD:
                raise ReaderCrashedError(where)

        longest = max(path.stat().st_size for path in Path(corpus).iterdir()) * 2
        atheris.Setup(
            [
                sys.argv[0],
                corpus,
                f"-artifact_prefix={given.out}/",
                f"-max_len={longest}",
                "-print_final_stats=1",
                *options,
            ],
            one,
        )
        atheris.Fuzz()


if __name__ == "__main__":
    main()
