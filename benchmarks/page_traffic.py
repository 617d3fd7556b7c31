"""Network traffic of one open page: kB/s of pictures and of everything else.

    python -m benchmarks.page_traffic [--seconds 10]

One running program with a simulated camera (1280x960, 30 pictures a second, its usual noise) and a
robot that drives between two places. The pages are websockets without a screen, one at a time, that
acknowledge every picture at once, as a page does that has drawn it. Writes
benchmarks/results/page_traffic.md.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from websockets.asyncio.client import connect

from navigation.mission.mission import Station
from tests.browser.programs.live import Live, live_config
from tests.support.runs.packed import unpack

RESULT = Path(__file__).parent / "results" / "page_traffic.md"
SETTLE_S: Final = 2.0
"""A page gets world, plan, log and past at first, once."""
PLACES: Final = ((0.25, 0.75), (0.30, 1.50))
"""Free, and far enough apart to drive for some seconds."""
KILO: Final = 1000.0
CAMERA_HZ: Final = 30
BEFORE: Final = "| version 1.0, any page | 30.0 | 27.0 | 810 | 16 | 826 |"
"""Measured by this command with the sources of that version: one size for all pages."""

PAGES: Final[dict[str, dict[str, Any]]] = {
    "window of 1920 x 1080": {"on": True, "width_px": 1071},
    "window of 1440 x 900": {"on": True, "width_px": 837},
    "phone, 390 x 844 at 3 pixels each": {"on": True, "width_px": 1080},
    "half a screen, 700 x 900": {"on": True, "width_px": 640},
    "small window": {"on": True, "width_px": 300},
    "hidden": {"on": False, "width_px": 837},
}
"""Views that a page of each kind asks for."""


@dataclass(frozen=True, slots=True)
class Traffic:
    """Bytes by kind of message in ``seconds``, and how many pictures."""

    sent: Counter[str]
    pictures: int
    seconds: float

    def kilobytes_s(self, *kinds: str) -> float:
        """Kilobytes a second of these kinds, of all without any."""
        return sum(n for kind, n in self.sent.items() if not kinds or kind in kinds) / (
            KILO * self.seconds
        )


async def look(address: str, watch: dict[str, Any], seconds: float) -> Traffic:
    """Be a page for some seconds."""
    sent: Counter[str] = Counter()
    pictures = 0
    async with connect(address, subprotocols=["clearway.1"]) as line:  # type: ignore[list-item]
        await line.send(json.dumps({"type": "watch", **watch}))
        began_s = time.monotonic() + SETTLE_S
        while (left_s := began_s + seconds - time.monotonic()) > 0.0:
            try:
                data = await asyncio.wait_for(line.recv(), left_s)
            except TimeoutError:
                break
            head = unpack(data)[0] if isinstance(data, bytes) else json.loads(data)
            if head["type"] == "picture":
                await line.send(json.dumps({"type": "ack", "number": head["number"]}))
            if time.monotonic() >= began_s:
                sent[head["type"]] += len(data)
                pictures += head["type"] == "picture"
    return Traffic(sent, pictures, seconds)


def keep_driving(live: Live) -> None:
    """Send the robot to and fro for longer than a page looks."""
    stations = tuple(Station(*place) for place in PLACES * 10)
    live.daemon.people.give(stations)


def measure(watch: dict[str, Any], seconds: float) -> Traffic:
    """A program of its own for each page: all meet the same run."""
    with Live(live_config(rate_hz=CAMERA_HZ)) as live:
        keep_driving(live)
        address = live.url.replace("http", "ws") + "live"
        return asyncio.run(look(address, watch, seconds))


def table(found: dict[str, Traffic], seconds: float) -> str:
    """The results as Markdown, at the rate that the program promises."""
    rate = live_config(rate_hz=CAMERA_HZ).dashboard.picture_rate_hz
    lines = [
        "# What a page costs on the network",
        "",
        "The shipped simulation at 1280x960, 30 pictures a second, the robot driving, one page",
        f"at a time for {seconds:g} s. Sizes are measured; the rate of pictures is the configured",
        "one, which a busy computer does not reach. `python -m benchmarks.page_traffic` makes this",
        "again.",
        "",
        "| page | pictures/s | kB a picture | kB/s of pictures | kB/s of the rest | kB/s |",
        "|---|---|---|---|---|---|",
        BEFORE,
    ]
    for name, one in found.items():
        size = one.sent["picture"] / KILO / max(1, one.pictures)
        pictures_s = rate if one.pictures else 0.0
        rest = one.kilobytes_s() - one.kilobytes_s("picture")
        lines.append(
            f"| {name} | {pictures_s:.1f} | {size:.1f} | {pictures_s * size:.0f} | {rest:.0f} "
            f"| {pictures_s * size + rest:.0f} |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0)
    asked = parser.parse_args()
    found = {}
    for name, watch in PAGES.items():
        one = found[name] = measure(watch, asked.seconds)
        print(f"{name}: {one.pictures} pictures, {one.kilobytes_s():.0f} kB/s", flush=True)
    text = table(found, asked.seconds)
    RESULT.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
