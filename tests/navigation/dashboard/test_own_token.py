"""The program's own token: made once, kept for the next start, nobody else's to read."""

import os
from pathlib import Path

import pytest

from navigation.dashboard.admission.own_token import own_token


def test_it_is_kept_and_is_the_owners_alone(tmp_path: Path) -> None:
    file = tmp_path / "c.sock.token"
    token = own_token(file)
    assert len(token) == 32
    assert file.stat().st_mode & 0o777 == 0o600
    assert own_token(file) == token, "the link survives a restart"
    assert list(tmp_path.iterdir()) == [file]
    file.unlink()
    assert own_token(file) != token


@pytest.mark.parametrize("harm", ["readable", "short", "empty", "binary", "link", "fifo", "folder"])
def test_a_file_that_is_not_ours_alone_or_holds_no_token_is_replaced(
    harm: str, tmp_path: Path
) -> None:
    file = tmp_path / "c.sock.token"
    known = "k" * 32
    other = tmp_path / "other"
    other.write_text(known)
    other.chmod(0o600)
    match harm:
        case "readable":
            file.write_text(known)
            file.chmod(0o644)
        case "link":
            file.symlink_to(other)
        case "fifo":
            os.mkfifo(file, 0o600)
        case "folder":
            file.mkdir()
            with pytest.raises(OSError, match="directory"):
                own_token(file)
            return
        case _:
            data = {"short": b"k" * 20, "empty": b"", "binary": b"\xff" * 32}[harm]
            file.write_bytes(data)
            file.chmod(0o600)
    token = own_token(file)
    assert token != known
    assert own_token(file) == token
    assert other.read_text() == known


def test_a_folder_that_cannot_be_written_to_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        own_token(tmp_path / "nowhere" / "c.sock.token")
