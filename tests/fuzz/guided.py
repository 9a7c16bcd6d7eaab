"""Coverage-guided fuzzing of a reader with Atheris: `python tests/fuzz/guided.py procedure`.

It starts from the valid files of `fuzz.py`, and mutates inputs further that reach new code. Needs
the extra `fuzz` (Linux and macOS). Options of libFuzzer follow the name, such as
`-max_total_time=600`. It ends at the first crash and saves the file in `--out`.
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
    """Reports a crash to libFuzzer."""


def main() -> None:
    """Fuzz one reader until it crashes or the time is up."""
    parser = argparse.ArgumentParser(description="Looks for files that crash a reader.")
    parser.add_argument("reader", choices=[target.name for target in TARGETS])
    parser.add_argument("--out", type=Path, default=Path("fuzz-crashes"))
    arguments, options = parser.parse_known_args()
    target = next(target for target in TARGETS if target.name == arguments.reader)
    arguments.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as corpus, tempfile.TemporaryDirectory() as folder:
        for number, seed in enumerate(seeds_of(target)):
            (Path(corpus) / f"seed{number}").write_bytes(seed)

        def read_one(data: bytes) -> None:
            outcome, where = verdict(target, data, Path(folder))
            if outcome not in GOOD:
                raise ReaderCrashedError(where)

        longest = max(path.stat().st_size for path in Path(corpus).iterdir()) * 2
        atheris.Setup(
            [
                sys.argv[0],
                corpus,
                f"-artifact_prefix={arguments.out}/",
                f"-max_len={longest}",
                "-print_final_stats=1",
                *options,
            ],
            read_one,
        )
        atheris.Fuzz()


if __name__ == "__main__":
    main()
