"""The fuzzers' corpus as text: one input a line, in hexadecimal.

python -m tests.support.wire.corpus unpack link FOLDER     for libFuzzer, which wants files
python -m tests.support.wire.corpus pack link FOLDER       from what its merge has kept
"""

from __future__ import annotations

import sys
from pathlib import Path

CORPUS = Path(__file__).parents[2] / "firmware_protocol" / "corpus"
KEPT_BYTES = 22_000
"""Of each fuzzer, the shortest inputs first: the repository is no place for more."""


def inputs(name: str) -> list[bytes]:
    """The inputs of ``link`` or ``robot``."""
    return [bytes.fromhex(line) for line in (CORPUS / f"{name}.txt").read_text().splitlines()]


def unpack(name: str, folder: Path) -> None:
    """Write each input into a file of its own."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(inputs(name)):
        (folder / f"{number:04d}").write_bytes(data)


def pack(name: str, folder: Path) -> None:
    """Replace the corpus by the files of a folder."""
    kept, size = [], 0
    for data in sorted((file.read_bytes() for file in folder.iterdir()), key=lambda d: (len(d), d)):
        size += len(data)
        if size <= KEPT_BYTES:
            kept.append(data.hex())
    (CORPUS / f"{name}.txt").write_text("\n".join(kept) + "\n")


def main() -> int:
    """See the module's text."""
    orders = {"unpack": unpack, "pack": pack}
    if len(sys.argv) != 4 or sys.argv[1] not in orders or sys.argv[2] not in ("link", "robot"):
        print(__doc__, file=sys.stderr)
        return 2
    orders[sys.argv[1]](sys.argv[2], Path(sys.argv[3]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
