"""The file of a journal: one row with a checksum in an SQLite database that one program uses.

Rules
- WAL with ``synchronous=FULL``: a kill at any moment loses nothing that was said to be saved,
  and never leaves half a record.
- Locked as long as it is open: a second program is refused.
- Readable by its owner only, its side files too.
- What cannot be trusted is kept aside under another name, for a person to look at, and the
  journal begins empty: damage, a record of an earlier format, another owner's mission. A file
  that was never a journal is refused and left alone.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import sqlite3
import stat
from pathlib import Path
from typing import Final

from navigation.journal.journal_records import Contents, Owner, RecordError, from_text, to_text

VERSION: Final = 2
APPLICATION_ID: Final = 0x434C5759
"""``CLWY``: what tells a journal from other programs' databases."""
LATEST_VERSION: Final = 1000
"""A number beyond it was never a version: it is damage."""
OPEN_WITHIN_S: Final = 5.0
"""At a run's beginning another program that only looks into the journal is waited for so long."""
MOST_BYTES: Final = 64_000_000
SIDE_FILES: Final = ("", "-wal", "-shm", "-journal")
"""What SQLite appends to the file's name for the files beside it."""
MOST_ASIDE: Final = 1000

_MAGIC: Final = b"SQLite format 3\x00"
_HEAD_BYTES: Final = 20
"""They end with the file format's two version numbers, 1 or 2 each."""
_LIKENESS: Final = 12
"""So many equal bytes of the first sixteen are a damaged database, not somebody's notes."""
_TABLE: Final = (
    "CREATE TABLE IF NOT EXISTS contents "
    "(one INTEGER PRIMARY KEY CHECK (one = 1), body TEXT NOT NULL, sum TEXT NOT NULL)"
)
_OLD_TABLES: Final = frozenset({"mission", "plan"})
"""Those of version 1, which had no application's number."""
_NO_ROOM: Final = frozenset({sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR})
_IN_USE: Final = frozenset({sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED})
_FORBIDDEN: Final = frozenset(
    {sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM}
)
_NO_ROOM_ERRNO: Final = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO})


class JournalError(ValueError):
    """The journal cannot be used; the message says which file and why."""


class JournalWriteError(JournalError):
    """The journal cannot be written at the moment: no room, an error of the disk, a lost file."""


class _UntrustedError(ValueError):
    """What is in the file must not be used; ``label`` goes into the name that it is kept under."""

    def __init__(self, label: str, message: str) -> None:
        super().__init__(message)
        self.label = label


class JournalFile:
    """An open, locked journal; ``contents`` is what was found in it, ``remark`` what was wrong."""

    def __init__(self, path: Path, owner: Owner, patience_s: float = OPEN_WITHIN_S) -> None:
        self.path, self.owner = path, owner
        self._patience_s = patience_s
        self.remark = ""
        self.contents: Contents | None = None
        try:
            self._open()
        except _UntrustedError as untrusted:
            aside = self._put_aside(untrusted.label)
            self.remark = (
                f"journal {path}: {untrusted}: kept as {aside.name}; the run begins without it"
            )
            self._open()

    def _open(self) -> None:
        try:
            self._make_private()
            self._look_like_a_journal()
            self._db = sqlite3.connect(self.path, isolation_level=None, timeout=self._patience_s)
        except OSError as error:
            kind = JournalWriteError if error.errno in _NO_ROOM_ERRNO else JournalError
            raise kind(f"journal {self.path}: {error.strerror or error}") from None
        except sqlite3.Error as error:
            raise self._error(error) from None
        try:
            self._prepare()
        except sqlite3.Error as error:
            if _code(error) not in _NO_ROOM | _IN_USE | _FORBIDDEN:
                raise _UntrustedError("damaged", f"is damaged ({error})") from None
            self._db.close()
            raise self._error(error) from None
        except UnicodeDecodeError:  # in SQLite's own sentence on a damaged name
            raise _UntrustedError("damaged", "is damaged (its tables' names)") from None
        except JournalError:
            self._db.close()
            raise

    def _make_private(self) -> None:
        """Make the file where there is none; its owner alone may read it in any case."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            os.close(os.open(self.path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        if not stat.S_ISREG(self.path.stat().st_mode):
            raise JournalError(f"journal {self.path}: is no ordinary file")
        for file in self._files():
            if file.exists() and stat.S_IMODE(file.stat().st_mode) & 0o077:
                file.chmod(0o600)

    def _files(self) -> list[Path]:
        return [self.path.with_name(self.path.name + end) for end in SIDE_FILES]

    def _look_like_a_journal(self) -> None:
        with self.path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
        magic, versions = head[: len(_MAGIC)], head[18:20]
        if not head or (magic == _MAGIC and all(one in (1, 2) for one in versions)):
            return
        alike = sum(one == other for one, other in zip(magic, _MAGIC, strict=False))
        if alike >= _LIKENESS or not any(head):
            raise _UntrustedError("damaged", "is damaged (its first bytes)")
        raise JournalError(f"journal {self.path}: is no journal: name another file, or remove it")

    def _prepare(self) -> None:
        # the lock is held until the file is closed, and no file of shared memory is needed
        self._db.execute("PRAGMA locking_mode=EXCLUSIVE")
        self._db.execute("PRAGMA journal_mode=WAL")
        self._db.execute("PRAGMA synchronous=FULL")
        self._refuse_strangers()
        self._db.execute("BEGIN IMMEDIATE")
        self._db.execute(_TABLE)
        self._db.execute(f"PRAGMA application_id={APPLICATION_ID}")
        self._db.execute(f"PRAGMA user_version={VERSION}")
        self._db.execute("COMMIT")
        self._db.execute("PRAGMA busy_timeout=0")  # nobody else can hold it from here on
        self._inodes = self._present()
        self.contents = self._read()

    def _refuse_strangers(self) -> None:
        """JournalError for other programs' and later files, which are left as they are."""
        found = str(self._db.execute("PRAGMA quick_check(1)").fetchone()[0])
        if found != "ok":
            raise _UntrustedError("damaged", f"is damaged ({found.splitlines()[0][:100]})")
        version = int(self._db.execute("PRAGMA user_version").fetchone()[0])
        application = int(self._db.execute("PRAGMA application_id").fetchone()[0])
        rows = self._db.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
        tables = {str(name) for (name,) in rows}
        if application != APPLICATION_ID and not (tables <= _OLD_TABLES or tables == {"contents"}):
            raise JournalError(
                f"journal {self.path}: is another program's database: name another file"
            )
        if not 0 <= version <= LATEST_VERSION:
            raise _UntrustedError("damaged", f"is damaged (version {version})")
        if version > VERSION:
            raise JournalError(
                f"journal {self.path}: is of version {version}, this program writes {VERSION}: "
                "name another file, or remove it"
            )
        if tables and version < VERSION:
            sentence = f"is of version {version}, which does not say whose mission it holds"
            raise _UntrustedError(f"version{version}", sentence)

    def _read(self) -> Contents | None:
        row = self._db.execute(
            "SELECT CASE WHEN length(body) <= ? THEN body END, sum FROM contents", (MOST_BYTES,)
        ).fetchone()
        if row is None:
            return None
        body, checksum = row
        if not isinstance(body, str) or checksum != _sum(body):
            raise _UntrustedError("damaged", "is damaged (its checksum)")
        try:
            contents = from_text(body)
        except RecordError as error:
            raise _UntrustedError("damaged", f"cannot be used ({error})") from None
        if contents.owner != self.owner:
            difference = self.owner.difference(contents.owner)
            raise _UntrustedError("other", f"holds a mission of {difference}")
        return contents

    def _put_aside(self, label: str) -> Path:
        """Rename what is there, so that nothing is lost; the new name."""
        for number in range(1, MOST_ASIDE + 1):
            aside = self.path.with_name(f"{self.path.name}.{label}-{number}")
            if not aside.exists():
                break
        else:
            raise JournalError(f"journal {self.path}: {MOST_ASIDE} files are kept aside already")
        try:
            for file, end in zip(self._files(), SIDE_FILES, strict=True):
                if file.exists():
                    file.rename(aside.with_name(aside.name + end))
        except OSError as error:
            raise JournalError(f"journal {self.path}: {error.strerror or error}") from None
        finally:
            if hasattr(self, "_db"):  # the lock is held until the names are others
                self._db.close()
        return aside

    def save(self, contents: Contents) -> None:
        """Keep the contents; ``JournalWriteError`` where they are not on the disk now."""
        if self._present() != self._inodes:
            raise JournalWriteError(f"journal {self.path}: was deleted or replaced by another file")
        body = to_text(contents)
        try:
            self._db.execute("BEGIN IMMEDIATE")
            try:
                self._db.execute(
                    "INSERT OR REPLACE INTO contents VALUES (1, ?, ?)", (body, _sum(body))
                )
                self._db.execute("COMMIT")
            finally:
                if self._db.in_transaction:
                    self._db.execute("ROLLBACK")
        except sqlite3.Error as error:
            raise self._error(error) from None

    def _present(self) -> list[tuple[int, int] | None]:
        """Which files the two names are now; a deleted file could be written for ever."""
        found: list[tuple[int, int] | None] = []
        for file in self._files()[:2]:
            try:
                told = file.stat()
            except OSError:
                found.append(None)
            else:
                found.append((told.st_dev, told.st_ino))
        return found

    def discard(self) -> None:
        """Remove the file, where what is in it would mislead the next program."""
        if self._present() == self._inodes:
            for file in self._files():
                with contextlib.suppress(OSError):  # what is left is no worse than before
                    file.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the file, which ends the lock."""
        with contextlib.suppress(sqlite3.Error):  # what was saved is in the file already
            self._db.close()

    def _error(self, error: sqlite3.Error) -> JournalError:
        code = _code(error)
        if code in _IN_USE:
            return JournalError(
                f"journal {self.path}: is in use by another program, a running clearway most "
                "likely: give each its own recording.journal"
            )
        kind = JournalError if code in _FORBIDDEN else JournalWriteError
        return kind(f"journal {self.path}: cannot be written: {error}")


def _code(error: sqlite3.Error) -> int:
    """SQLite's number of what went wrong, without the details."""
    return int(getattr(error, "sqlite_errorcode", 0) or 0) & 0xFF


def _sum(body: str) -> str:
    return hashlib.sha256(body.encode()).hexdigest()
