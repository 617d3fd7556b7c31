"""Small files that claim much: one sentence, and no more memory than an honest recording needs.

They are written here by hand, from the MCAP, zstd and LZ4 specifications.
"""

from __future__ import annotations

import json
import resource
import struct
import subprocess
import sys
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any

import lz4.frame
import pytest
import zstandard
from mcap.reader import make_reader

from navigation.recording.files import RecordingError
from navigation.recording.json_bodies import CONFIGURATION, PLANS, REQUESTS, SCENES
from navigation.recording.reader import bytes_field, decoded_picture, read_recording
from navigation.recording.tape import read_tape
from navigation.run.replay import replay
from tests.support.files.png_pictures import chunk as png_chunk
from tests.support.pictures import call
from tests.support.runs.recordings import small_recording

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, CHANNEL, MESSAGE, CHUNK, ATTACHMENT, UNKNOWN = 1, 2, 4, 5, 6, 9, 0x7F
GIB = 1 << 30
MORE_BYTES = GIB // 2
"""Memory that reading may take beside what is there when the libraries are loaded."""
READ = """
import resource, sys
from pathlib import Path
from navigation.recording.files import RecordingError
from navigation.recording.tape import read_tape
pages = int(Path("/proc/self/statm").read_text().split()[0])
most = pages * resource.getpagesize() + int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_AS, (most, most))
try:
    read_tape(Path(sys.argv[1]))
except RecordingError as error:
    sys.exit(f"refused: {error}")
"""


def record(kind: int, body: bytes, length: int | None = None) -> bytes:
    """A record, which may claim another length than it has."""
    return struct.pack("<BQ", kind, len(body) if length is None else length) + body


def text(of: bytes, length: int | None = None) -> bytes:
    return struct.pack("<I", len(of) if length is None else length) + of


def channel(topic: bytes = b"/clearway/configuration", number: int = 1) -> bytes:
    body = struct.pack("<HH", number, 0) + text(topic) + text(b"json") + text(b"")
    return record(CHANNEL, body)


def message(data: bytes, number: int = 1) -> bytes:
    return record(MESSAGE, struct.pack("<HIQQ", number, 0, 1, 1) + data)


def packed(kind: bytes, size: int, data: bytes, claimed: int | None = None, crc: int = 0) -> bytes:
    """A chunk that declares ``size`` bytes unpacked; ``claimed``: of its data."""
    length = len(data) if claimed is None else claimed
    times = struct.pack("<QQQI", 0, 0, size, crc)
    return record(CHUNK, times + text(kind) + struct.pack("<Q", length) + data)


def whole(*records: bytes) -> bytes:
    footer = record(FOOTER, struct.pack("<QQI", 0, 0, 0))
    return MAGIC + record(HEADER, text(b"") + text(b"")) + b"".join(records) + footer + MAGIC


def zstd_zeros(size: int, *, says_size: bool) -> bytes:
    """So many zeros in blocks of 4 bytes that repeat one byte 128 KiB times (RFC 8878, 3.1.1)."""
    block = 128 << 10
    count = size // block
    descriptor = struct.pack("<BBQ", 0xC0, 0x38, size) if says_size else b"\x00\x38"
    blocks = [
        ((block << 3) | (1 << 1) | (n == count - 1)).to_bytes(3, "little") for n in range(count)
    ]
    return b"\x28\xb5\x2f\xfd" + descriptor + b"".join(head + b"\x00" for head in blocks)


def lz4_zeros(size: int) -> bytes:
    """So many zeros, of which the first 4 MiB are packed once and repeated."""
    one = 4 << 20
    frame = lz4.frame.compress(
        bytes(one), block_size=lz4.frame.BLOCKSIZE_MAX4MB, block_linked=False, store_size=False
    )
    head, block, end = frame[:7], frame[7:-4], frame[-4:]
    return head + block * (size // one) + end


HUGE = (2**31, 2**32 - 1, 2**62, 2**63 - 1, 2**63, 2**64 - 1)

LIES = {
    "record": [MAGIC + record(kind, b"", n) for kind in (CHANNEL, UNKNOWN, CHUNK) for n in HUGE],
    "in a chunk": [
        whole(channel(), packed(b"", 9 + 3, record(kind, b"abc", n)))
        for kind in (CHANNEL, MESSAGE, UNKNOWN)
        for n in HUGE
    ],
    "a chunk's data": [whole(channel(), packed(b"", 4, b"abcd", n)) for n in HUGE],
    "a string": [
        whole(record(CHANNEL, struct.pack("<HH", 1, 0) + text(b"/x", n))) for n in HUGE[:2]
    ],
    "a map": [
        whole(record(CHANNEL, struct.pack("<HH", 1, 0) + text(b"/x") + text(b"") + text(b"", n)))
        for n in HUGE[:2]
    ],
    "an attachment": [
        whole(record(ATTACHMENT, bytes(16) + text(b"") + text(b"") + struct.pack("<Q", n)))
        for n in HUGE
    ],
    "a short message": [whole(channel(), record(MESSAGE, b"abc"))],
    "another packing": [whole(channel(), packed(b"\xffx", 4, b"abcd"), message(b"{}"))],
    "no zstd": [whole(channel(), packed(b"zstd", 4, b"abcd"))],
    "no lz4": [whole(channel(), packed(b"lz4", 4, b"abcd"))],
}


def test_a_length_that_leads_past_its_end_is_refused_by_one_sentence(tmp_path: Path) -> None:
    file = tmp_path / "lie.mcap"
    for what, contents in LIES.items():
        for content in contents:
            file.write_bytes(content)
            with pytest.raises(RecordingError, match=r"lie\.mcap: ") as refused:
                read_tape(file)
            assert len(str(refused.value).splitlines()) == 1, what


@pytest.mark.parametrize("command", [("replay",), ("dashboard", "--no-browser")])
def test_both_commands_say_it_and_end_with_code_2(tmp_path: Path, command: tuple[str, ...]) -> None:
    file = tmp_path / "lie.mcap"
    for content in (LIES["record"][-1], LIES["in a chunk"][-1], LIES["a chunk's data"][-1]):
        file.write_bytes(content)
        told = call(*command, file)
        assert (told.code, told.out) == (2, ""), told
        assert "lie.mcap" in told.err
        assert "unexpected" not in told.err


@pytest.mark.parametrize(
    "bomb",
    [
        packed(b"zstd", 3 * GIB, zstd_zeros(3 * GIB, says_size=True)),
        packed(b"zstd", 1000, zstd_zeros(3 * GIB, says_size=True)),
        packed(b"zstd", 1000, zstd_zeros(3 * GIB, says_size=False)),
        packed(b"zstd", 64 << 20, zstd_zeros(3 * GIB, says_size=False)),
        packed(b"lz4", GIB, lz4_zeros(GIB)),
        packed(b"lz4", 1000, lz4_zeros(GIB)),
    ],
    ids=["zstd", "zstd lies", "zstd without a size", "zstd, some", "lz4", "lz4 lies"],
)
def test_a_chunk_that_unpacks_to_gigabytes_is_refused_in_little_memory(
    tmp_path: Path, bomb: bytes
) -> None:
    file = tmp_path / "bomb.mcap"
    file.write_bytes(whole(channel(), bomb))
    command = [sys.executable, "-c", READ, str(file), str(MORE_BYTES)]
    told = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert told.returncode == 1, told.stderr
    assert told.stderr.startswith("refused: "), told.stderr
    assert len(told.stderr.splitlines()) == 1


def test_the_bombs_are_what_they_are_called() -> None:
    small = 1 << 20
    for says_size in (True, False):
        frame = zstd_zeros(small, says_size=says_size)
        assert zstandard.ZstdDecompressor().stream_reader(frame).read() == bytes(small)
    assert len(zstd_zeros(3 * GIB, says_size=True)) < 99_000
    assert lz4.frame.decompress(lz4_zeros(12 << 20)) == bytes(12 << 20)


@pytest.mark.parametrize("kind", ["lz4", "zstd"])
def test_a_recording_that_somebody_packed_is_read_as_before(
    jpeg: Path, tmp_path: Path, kind: str
) -> None:
    """Each chunk of the recording, packed by the library's own function."""
    pack = {"lz4": lz4.frame.compress, "zstd": zstandard.compress}[kind]
    data, at, made = jpeg.read_bytes(), len(MAGIC), [MAGIC]
    while at < len(data) - len(MAGIC):
        sort, length = struct.unpack_from("<BQ", data, at)
        body = data[at + 9 : at + 9 + length]
        if sort == CHUNK:
            inner = body[28 + 4 + 8 :]
            made.append(packed(kind.encode(), len(inner), pack(inner), crc=zlib.crc32(inner)))
        else:
            made.append(record(sort, body))
        at += 9 + length
    file = tmp_path / "packed.mcap"
    file.write_bytes(b"".join(made) + MAGIC)
    assert file.stat().st_size < len(data)
    tape, plain = read_tape(file), read_tape(jpeg)
    assert not tape.recording.cut
    assert tape.recording.frames == plain.recording.frames
    assert (tape.image(tape.pictures[3]) == plain.image(plain.pictures[3])).all()


def test_a_picture_that_claims_gigabytes_is_not_decoded(tmp_path: Path) -> None:
    side = 60_000
    header = png_chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0))
    png = (
        b"\x89PNG\r\n\x1a\n"
        + header
        + png_chunk(b"IDAT", zlib.compress(b""))
        + png_chunk(b"IEND", b"")
    )
    field = bytes([2 << 3 | 2, len(png)]) + png
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(RecordingError, match="60000 x 60000 pixels: must be at most"):
        decoded_picture(field, tmp_path / "a.mcap")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000


def test_a_number_without_an_end_is_no_long_work() -> None:
    assert bytes_field(b"\xff" * 3_000_000, 2) == b""


@pytest.mark.parametrize(
    "body", [b"[]", b"3", b"null", b'{"schema": 1' + b"0" * 5000 + b"}", b"[" * 100_000, b"\xff"]
)
def test_a_body_of_another_kind_is_said_in_one_sentence(tmp_path: Path, body: bytes) -> None:
    file = tmp_path / "body.mcap"
    file.write_bytes(whole(channel(), message(body)))
    with pytest.raises(RecordingError, match="cannot be read") as refused:
        read_recording(file)
    assert len(str(refused.value).splitlines()) == 1


def chunks_of(data: bytes) -> bytes:
    """A recording up to the end of its last chunk."""
    at = len(MAGIC)
    while data[at] in (HEADER, CHUNK):
        at += 9 + struct.unpack_from("<Q", data, at + 1)[0]
    return data[:at]


@pytest.mark.parametrize(
    ("topic", "body"),
    [
        (b"/clearway/frames", b'{"captured_s": 1' + b"0" * 400 + b', "poses": []}'),
        (b"/clearway/frames", b'{"captured_s": -1e999, "poses": []}'),
        (b"/clearway/frames", b'{"captured_s": NaN, "poses": []}'),
        (b"/clearway/link", b'{"age_s": Infinity}'),
        (b"/clearway/frames", b"[]"),
        (b"/clearway/scenes", b'{"captured_s": 0, "revision": 1e999, "carried": 0, "scene": ""}'),
        (b"/clearway/fleet/waits", b"[]"),
        (b"/clearway/fleet/waits", b'{"waits": 1}'),
        (b"/clearway/fleet/waits", b'{"waits": 1, "waits_for": {}}'),
        (b"/clearway/fleet/waits", b'{"waits": {"a": []}, "waits_for": {}}'),
        (b"/clearway/link", b"{"),
        (b"/clearway/link/a", b"[]"),
        (b"/clearway/link", b'{"executed": []}'),
        (b"/clearway/link", b'{"state": []}'),
        (b"/clearway/link", b'{"rtt_s": "1"}'),
        (b"/clearway/link", b'{"rtt_s": 1e308}'),
        (b"/clearway/link", b'{"sent": {"frames_sent": "x"}}'),
        (b"/clearway/frames", b'{"captured_s": 1e308, "poses": []}'),
        (
            b"/clearway/frames",
            b'{"captured_s": 1, "poses": [{"id": 1, "x_m": 1e308, "y_m": 0, "heading_rad": 0}]}',
        ),
        (b"/clearway/zones", b'{"time_s": 1, "revision": 1, "zones": 7}'),
        (b"/clearway/zones", b'{"time_s": 1, "revision": 1, "zones": [{"name": "a"}]}'),
        (
            b"/clearway/zones",
            b'{"time_s": 1, "revision": 1, "zones": [{"name": "a", "kind": "wait",'
            b' "area": {"circle": [1, 1, 0]}, "robots": [], "speed_m_s": null, "cost": null}]}',
        ),
    ],
)
def test_a_damaged_message_later_in_a_recording_is_said_in_one_sentence(
    jpeg: Path, tmp_path: Path, topic: bytes, body: bytes
) -> None:
    file = tmp_path / "body.mcap"
    file.write_bytes(chunks_of(jpeg.read_bytes()) + channel(topic, 999) + message(body, 999))
    with pytest.raises(RecordingError, match="cannot be read") as refused:
        read_tape(file)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize(
    "path", [7, [[0.0, 1.0, 2.0]], [["a", "b"]], [[1e308, 0.0], [0.0, 0.0]], None]
)
def test_a_plan_whose_path_cannot_be_shown_is_said_in_one_sentence(
    tmp_path: Path, path: object
) -> None:
    """The page showed nothing of the run while that plan held."""
    data = small_recording()
    found = {c.topic: m.data for _, c, m in make_reader(BytesIO(data)).iter_messages()}
    asked, told = json.loads(found[REQUESTS]), json.loads(found[PLANS])
    asked["request"]["id"] = told["id"] = 999
    told["path"] = path
    said = b""
    for number, (topic, body) in enumerate(((REQUESTS, asked), (PLANS, told)), 900):
        said += channel(topic.encode(), number) + message(json.dumps(body).encode(), number)
    file = tmp_path / "plan.mcap"
    file.write_bytes(chunks_of(data) + said)
    with pytest.raises(RecordingError, match="cannot be read") as refused:
        read_tape(file)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("section", "value", "says"),
    [
        ("arena", {"bounds_m": [0.0, 0.0, 0.0, 0.0]}, "arena.bounds_m: must be"),
        (
            "robots",
            [{"name": "a", "marker_id": 1}, {"name": "a", "marker_id": 2}],
            "robots[1].name: 'a' is the name of robots[0] already",
        ),
        (
            "robots",
            [{"name": "a", "marker_id": 1}, {"name": "b", "marker_id": 1}],
            "robots[1].marker_id: 1 is robots[0] (a)'s already",
        ),
    ],
)
def test_a_configuration_that_cannot_be_replayed_is_said_in_one_sentence(
    tmp_path: Path, section: str, value: Any, says: str
) -> None:
    found = {c.topic: m.data for _, c, m in make_reader(BytesIO(small_recording())).iter_messages()}
    body = json.loads(found[CONFIGURATION])
    config = body["config"]
    config[section] = {**config[section], **value} if isinstance(value, dict) else value
    file = tmp_path / "run.mcap"
    file.write_bytes(whole(channel(), message(json.dumps(body).encode())))
    with pytest.raises(RecordingError, match="cannot be read") as refused:
        read_recording(file)
    assert says in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


def test_a_recording_that_was_cut_before_its_first_scene_is_replayed(tmp_path: Path) -> None:
    """The comparison of scenes ended with a traceback where there were none."""
    data = small_recording()
    topics: dict[str, int] = {}
    said = b""
    for _, one, sent in make_reader(BytesIO(data)).iter_messages():
        if one.topic == SCENES:
            break
        if one.topic not in topics:
            topics[one.topic] = len(topics) + 1
            said += channel(one.topic.encode(), topics[one.topic])
        times = struct.pack("<HIQQ", topics[one.topic], 0, sent.log_time, sent.publish_time)
        said += record(MESSAGE, times + sent.data)
    file = tmp_path / "cut.mcap"
    file.write_bytes(MAGIC + record(HEADER, text(b"") + text(b"")) + said)
    recording = read_recording(file)
    assert recording.frames
    assert recording.scenes == []
    assert replay(recording).is_equal
