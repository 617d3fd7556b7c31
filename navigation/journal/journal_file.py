"""A journal's file: one sealed text, written whole, used by one program.

Rules
- A save is on disk when it returns: a kill at any moment leaves this entry or the previous one,
  whole.
- A file beside it, never replaced, locks it while it is open: a second program is refused.
- Readable by its owner only.
- Untrusted content (damage, or another owner's mission) is kept under another name, and the journal
  begins empty. A file that was never a journal, or of another version, is refused and left alone.
"""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path
from typing import Final

from navigation.journal.journal_lock import (
    OPEN_WITHIN_S,
    JournalError,
    JournalLock,
    JournalWriteError,
    error_of,
    identity,
)
from navigation.journal.journal_records import Contents, Owner, RecordError, from_text, to_text
from navigation.shared.sealed import SealError, seal, unseal
from navigation.shared.whole_file import UnwrittenFileError, sync_folder, write_whole

KIND: Final = "journal"
VERSION: Final = 3
MOST_BYTES: Final = 64_000_000
MOST_ASIDE: Final = 1000

_MAGIC: Final = f"clearway {KIND} ".encode()
_LIKENESS: Final = 12
"""A file with this many equal bytes at its beginning is a damaged journal, not a person's notes."""


class _UntrustedError(ValueError):
    """Error: untrusted content; ``label`` goes into the name it is kept under."""

    def __init__(self, label: str, message: str) -> None:
        super().__init__(message)
        self.label = label


class JournalFile:
    """An open, locked journal; ``contents`` is what it held, ``remark`` what was wrong."""

    def __init__(self, path: Path, owner: Owner, patience_s: float = OPEN_WITHIN_S) -> None:
        self.path, self.owner = path, owner
        self._file = Path(os.path.realpath(path))  # a link to it stays one
        self._lock: JournalLock | None = None
        self.remark = ""
        self.contents: Contents | None = None
        try:
            self._make_private()
            self._take_lock(patience_s)
            try:
                self.contents = self._read()
            except _UntrustedError as untrusted:
                aside = self._put_aside(untrusted.label)
                self.remark = (
                    f"journal {path}: {untrusted}: kept as {aside.name}; the run begins without it"
                )
        except OSError as error:
            self.close()
            raise error_of(path, error) from None
        except JournalError:
            self.close()
            raise
        self._seen = self._present()

    def _make_private(self) -> None:
        self._file.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileNotFoundError):
            mode = self._file.stat().st_mode
            if not stat.S_ISREG(mode):
                raise JournalError(f"journal {self.path}: is no ordinary file")
            if stat.S_IMODE(mode) & 0o077:
                self._file.chmod(0o600)

    def _take_lock(self, patience_s: float) -> None:
        self._lock = JournalLock(self.path, patience_s)

    def _read(self) -> Contents | None:
        try:
            with self._file.open("rb") as file:
                data = file.read(MOST_BYTES)
        except FileNotFoundError:
            return None
        self._look_like_a_journal(data)
        try:
            contents = from_text(self._unsealed(data))
        except SealError as error:
            raise _UntrustedError("damaged", str(error)) from None
        except RecordError as error:
            raise _UntrustedError("damaged", f"cannot be used ({error})") from None
        if contents.owner != self.owner:
            difference = self.owner.difference(contents.owner)
            raise _UntrustedError("other", f"holds a mission of {difference}")
        return contents

    def _look_like_a_journal(self, data: bytes) -> None:
        """Raise JournalError for other programs' files."""
        if data.startswith(_MAGIC) or not data:
            return
        if _is_alike(data) or not any(data):
            raise _UntrustedError("damaged", "is damaged (its first bytes)")
        raise JournalError(f"journal {self.path}: is no journal: name another file, or remove it")

    def _unsealed(self, data: bytes) -> str:
        number = data[len(_MAGIC) :].split(b" ", 1)[0]
        version = int(number) if number.isdigit() and len(number) < 4 else VERSION
        text = unseal(KIND, version, data)
        if version != VERSION:
            raise JournalError(
                f"journal {self.path}: is of version {version}, this program writes {VERSION}: "
                "name another file, or remove it"
            )
        return text

    def _put_aside(self, label: str) -> Path:
        for number in range(1, MOST_ASIDE + 1):
            aside = self._file.with_name(f"{self._file.name}.{label}-{number}")
            if not aside.exists():
                break
        else:
            raise JournalError(f"journal {self.path}: {MOST_ASIDE} files are kept aside already")
        self._file.rename(aside)
        return aside

    def save(self, contents: Contents) -> None:
        """Save the contents; ``JournalWriteError`` if they are not on disk now."""
        if self._present() != self._seen:
            raise JournalWriteError(f"journal {self.path}: was deleted or replaced by another file")
        sealed = seal(KIND, VERSION, to_text(contents))
        try:
            write_whole(self._file, sealed, private=True, durable=True)
        except UnwrittenFileError as error:
            raise JournalWriteError(f"journal {error}") from None
        finally:
            self._seen = self._present()

    def _present(self) -> list[tuple[int, int] | None]:
        """Identities of the journal and its lock: both may be deleted meanwhile."""
        return [identity(self._file), None if self._lock is None else identity(self._lock.file)]

    def discard(self) -> None:
        """Remove the file: its content would mislead the next program."""
        if self._present() == self._seen:
            with contextlib.suppress(OSError):  # the remains are no worse than before
                self._file.unlink(missing_ok=True)
                sync_folder(self._file.parent)

    def close(self) -> None:
        """Release the lock."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None


def _is_alike(data: bytes) -> bool:
    equal = sum(one == other for one, other in zip(data, _MAGIC, strict=False))
    return equal >= _LIKENESS or _MAGIC.startswith(data)
