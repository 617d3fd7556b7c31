"""Damaged files for every reader, and what a reader may answer to them.

    python -m tests.support.files.reader_fuzz [--count 20000] [--seed 0] [--keep FOLDER]

runs a campaign and prints each file that got a wrong answer. A reader may answer with what it
read, or with its own kind of error and one sentence; never with another exception, and never
after more than ``MOST_S`` seconds. The same seed makes the same files.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from navigation.cli.pictures.sources import load_source
from navigation.recording.files import RecordingError
from navigation.recording.tape import Tape, read_tape
from planner.formats.scene_io import read_scene_text, write_scene_text
from planner.formats.scene_json import scene_to_json
from planner.scene import Scene, SceneError
from tests.support.files.picture_formats import formats
from tests.support.files.picture_harms import cut, flip, harms_for, put_number, splice
from tests.support.files.recording_harms import MAGIC, message_body
from tests.support.files.text_harms import TEXT_HARMS
from tests.support.runs.recordings import small_recording
from vision import extract
from vision.calibrate.survey import Survey, read_survey
from vision.calibration.calibration import Calibration, CalibrationError
from vision.calibration.calibration_file import calibration_text, load_calibration
from vision.camera.camera import CameraError
from vision.camera.picture_files import read_picture
from vision.picture_error import PictureError

MOST_S = 5.0
MOST_CHARACTERS = 400
MAP_PICTURES = (".pgm", "c0_8.png", "c2_16.png", "c3_1_t.png", "c4_8_i.png", "cmyk.jpg")
"""Pictures that are read as those of a ROS map too."""

REFUSALS = (SceneError, PictureError, CalibrationError, CameraError, RecordingError)

PLAIN_SCENE = """\
# figure 6
L 4 (10,10)(30,10)(30,30)(10,30)
P (50,50)
S (60,20) (80,25)
C (60,60) 8.25
A 3 (5,60) (12,66) (20,61)
"""

MOVINGAI = "type octile\nheight 5\nwidth 6\nmap\n......\n..@@..\n.T..W.\n...GS.\n@@@...\n"

ROS_YAML = """\
image: map.pgm
resolution: 0.05
origin: [-1.5, 2.0, 0.1]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
mode: trinary
"""

SURVEY = "px,py,x_m,y_m\n10,10,0.0,1.0\n90,12,1.0,1.0  # door\n88,70,1.0,0.0\n9,71,0,0\n"


@dataclass(frozen=True)
class Reader:
    """``read`` takes the file that the seed's mutant was written to, as ``name``."""

    read: Callable[[Path], object]
    name: str
    beside: tuple[tuple[str, bytes], ...] = ()


@dataclass(frozen=True)
class Finding:
    """A file that got a wrong answer."""

    what: str
    data: bytes
    answer: str


def rich_scene() -> Scene:
    """A hole, a circle, an arc, a point and a line, as ``clearway extract`` would tell them."""
    picture = np.full((60, 80), 220, np.uint8)
    cv2.rectangle(picture, (6, 6), (30, 30), 30, -1)
    cv2.circle(picture, (18, 18), 6, 220, -1)
    cv2.circle(picture, (55, 20), 9, 30, -1)
    cv2.ellipse(picture, (40, 45), (12, 12), 0, 180, 360, 30, -1)
    picture[50, 5], picture[55, 10:30] = 0, 0
    return extract(picture)


def seeds() -> dict[str, tuple[Reader, bytes]]:
    """What is damaged, by name: a reader and a file that is well."""
    found: dict[str, tuple[Reader, bytes]] = {}
    for name, data in formats():
        found[f"source {name}"] = Reader(load_source, name), data
        found[f"picture {name}"] = Reader(read_picture, name), data
        if name.endswith(MAP_PICTURES):
            header = ROS_YAML.replace("map.pgm", name).encode()
            found[f"map {name}"] = (
                Reader(
                    lambda path: load_source(path.with_name("map.yaml")),
                    name,
                    (("map.yaml", header),),
                ),
                data,
            )
    grey_pgm = dict(formats())["binary.pgm"]
    found["plain scene"] = Reader(load_source, "scene.txt"), PLAIN_SCENE.encode()
    found["scene text"] = Reader(load_source, "full.txt"), write_scene_text(rich_scene()).encode()
    found["scene json"] = (
        Reader(load_source, "full.json"),
        json.dumps(scene_to_json(rich_scene())).encode(),
    )
    found["movingai"] = Reader(load_source, "grid.map"), MOVINGAI.encode()
    found["ros yaml"] = (
        Reader(load_source, "map.yaml", (("map.pgm", grey_pgm),)),
        ROS_YAML.encode(),
    )
    found["survey"] = Reader(read_survey, "points.csv"), SURVEY.encode()
    calibration = calibration_text(Calibration.from_scale(0.01, (64, 48), (0.3, 0.2, 2.0)))
    found["calibration"] = Reader(load_calibration, "c.yaml"), calibration.encode()
    found["recording"] = Reader(watched, "run.mcap"), small_recording()
    return found


def watched(path: Path) -> Tape:
    """A recording, with each of its pictures looked at."""
    tape = read_tape(path)
    for picture in tape.pictures:
        tape.image(picture)
    return tape


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """A mutant of a file: one to four small harms."""
    text = b"\0" not in data[:64] and not data.startswith(b"\xff\xd8")
    for _ in range(int(rng.integers(1, 5))):
        own = (message_body,) if data.startswith(MAGIC) else harms_for(data)
        harms = BYTE_HARMS + (TEXT_HARMS if text else ()) + own * 8
        data = harms[int(rng.integers(len(harms)))](data, rng)
    return data


def flip_early(data: bytes, rng: np.random.Generator) -> bytes:
    """Headers matter most."""
    return flip(data[:64], rng) + data[64:]


def drop(data: bytes, rng: np.random.Generator) -> bytes:
    a, b = sorted(int(v) for v in rng.integers(0, len(data) + 1, 2))
    return data[:a] + data[min(b, a + 40) :]


def repeat(data: bytes, rng: np.random.Generator) -> bytes:
    a, b = sorted(int(v) for v in rng.integers(0, len(data) + 1, 2))
    return data[:b] + data[a:b] * int(rng.integers(1, 4)) + data[b:]


BYTE_HARMS = (cut, flip, flip_early, put_number, drop, repeat, splice)


def wrong_answer(reader: Reader, data: bytes, folder: Path) -> str:
    """What was wrong with a reader's answer to a file; empty where it was right."""
    for name, content in reader.beside:
        (folder / name).write_bytes(content)
    path = folder / reader.name
    path.write_bytes(data)
    begin_s = time.process_time()
    try:
        wrong = wrong_value(reader.read(path))
        if wrong:
            return wrong
    except REFUSALS as error:
        said = str(error)
        # A name may be long, the sentence may not.
        longest = max((len(word) for word in said.split()), default=0)
        if len(said.splitlines()) != 1 or len(said) - longest > MOST_CHARACTERS:
            return f"not one sentence: {said!r}"
        if not said.isprintable():
            return f"not printable: {said!r}"
        if str(folder) not in said:
            return f"does not name the file: {said!r}"
    except BaseException:  # noqa: BLE001 - every other exception is a finding, MemoryError too
        return traceback.format_exc(limit=-3)
    if time.process_time() - begin_s > MOST_S:
        return f"took {time.process_time() - begin_s:.1f} s"
    return ""


def wrong_value(value: object) -> str:
    """What no reader may give as read: no picture, no numbers, a scene that its text would lose."""
    if isinstance(value, np.ndarray):
        fine = value.dtype == np.uint8 and value.ndim in (2, 3) and value.size > 0
        return "" if fine and value.shape[2:] in ((), (3,)) else f"not a picture: {value.shape}"
    if isinstance(value, Scene) and read_scene_text(write_scene_text(value)) != value:
        return "the scene's text gives another scene"
    if isinstance(value, Survey):
        finite = np.isfinite(value.pixels).all() and np.isfinite(value.places_m).all()
        return "" if finite else "a survey of numbers that are none"
    if isinstance(value, Tape):
        moments = [value.begin_s, value.end_s, *(picture.captured_s for picture in value.pictures)]
        return "" if np.isfinite(moments).all() else f"a recording at no time: {moments}"
    if isinstance(value, Calibration):
        corners = value.arena_from_image(np.array([(0.0, 0.0), (value.size[0] - 1.0, 0.0)]))
        return "" if np.isfinite(corners).all() else "a calibration without places"
    return ""


def campaign(count: int, seed: int, folder: Path, only: str = "") -> Iterator[Finding]:
    """``count`` damaged files, in turn of every kind; those that got a wrong answer."""
    kinds = [(what, *rest) for what, rest in seeds().items() if only in what]
    for _, reader, data in kinds:
        wrong_answer(reader, data, folder)  # compiles what the clock must not see
    for number in range(count):
        what, reader, data = kinds[number % len(kinds)]
        mutant = damaged(data, np.random.default_rng((seed, number)))
        answer = wrong_answer(reader, mutant, folder)
        if answer:
            yield Finding(f"{what}, seed {seed}, number {number}", mutant, answer)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="kinds whose name holds this")
    parser.add_argument("--keep", type=Path, help="a folder for the files found")
    options = parser.parse_args()
    found = 0
    with tempfile.TemporaryDirectory() as folder:
        for finding in campaign(options.count, options.seed, Path(folder), options.only):
            found += 1
            print(f"{finding.what}\n{finding.answer}\n{finding.data[:300]!r}\n", flush=True)
            if options.keep is not None:
                options.keep.mkdir(parents=True, exist_ok=True)
                (options.keep / f"{found}.bin").write_bytes(finding.data)
    print(f"{options.count} damaged files, {found} wrong answers")
    return 1 if found else 0


if __name__ == "__main__":
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    sys.exit(main())
