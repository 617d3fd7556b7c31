"""The bundle for a report of a fault: one zip with what helps to understand it.

It holds findings, versions, the configuration with the files it names, the last run's report
and picture, and the head of the newest recording. Values that look like secrets are left out;
of the environment only Clearway's own variables are kept.
"""

from __future__ import annotations

import json
import platform
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Final

from navigation.config import Config
from navigation.config.last_good import LastGood, state_folder
from navigation.machine.doctor import Finding

MOST_RECORDING_BYTES: Final = 20_000_000
SECRET: Final = re.compile(r"(?i)(token|password|passwd|secret|api_?key)")
HIDDEN: Final = "(left out)"


def write_bundle(
    target: Path,
    file: Path | None,
    config: Config | None,
    findings: Iterable[Finding],
    environment: Mapping[str, str],
    now: datetime,
) -> list[str]:
    """Write the zip; the names of what is in it.

    ``file``, the configuration, may be broken: then its text is there and ``config`` is None.
    """
    names = []
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in _contents(file, config, findings, environment, now):
            archive.writestr(name, data)
            names.append(name)
    return names


def _contents(
    file: Path | None,
    config: Config | None,
    findings: Iterable[Finding],
    environment: Mapping[str, str],
    now: datetime,
) -> Iterator[tuple[str, str | bytes]]:
    told = [asdict(finding) for finding in findings]
    yield "findings.json", json.dumps(told, indent=2)
    yield "versions.json", json.dumps(_versions(now), indent=2)
    own = {
        name: HIDDEN if SECRET.search(name) else value
        for name, value in sorted(environment.items())
        if name.startswith("CLEARWAY_")
    }
    yield "environment.json", json.dumps(own, indent=2)
    if file is not None:
        yield from _file("configuration.yaml", file)
        kept = LastGood(file, state_folder(environment)).kept
        yield from _file("last_good.yaml", kept)
    if config is None:
        return
    if config.camera.calibration is not None:
        yield from _file("calibration.yaml", config.camera.calibration)
    if config.simulation is not None and config.simulation.arena is not None:
        yield from _file("arena.txt", config.simulation.arena)
    runs = sorted(folder for folder in config.recording.runs_dir.glob("*") if folder.is_dir())
    if runs:
        for one in sorted(runs[-1].iterdir()):
            if one.suffix in (".json", ".jsonl", ".svg"):
                yield from _file(f"last_run/{one.name}", one)
    yield from _newest_recording(config.recording.folder)


def _newest_recording(folder: Path) -> Iterator[tuple[str, bytes]]:
    """The head of it: a recording that is cut off can still be replayed."""
    files = sorted(folder.glob("clearway_*.mcap"))
    if files:
        with files[-1].open("rb") as recording:
            yield f"recording/{files[-1].name}", recording.read(MOST_RECORDING_BYTES)


def _file(name: str, file: Path) -> Iterator[tuple[str, str]]:
    """A text file without its secrets; nothing where it cannot be read."""
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return
    yield name, without_secrets(text)


def without_secrets(text: str) -> str:
    """The lines of a YAML or JSON text with the values of keys that look like secrets hidden."""
    lines = []
    for line in text.splitlines(keepends=True):
        key = re.match(r"(\s*[\"']?)([\w-]+)([\"']?\s*:\s*)\S", line)
        if key and SECRET.search(key.group(2)):
            end = "\n" if line.endswith("\n") else ""
            line = f"{key.group(1)}{key.group(2)}{key.group(3)}{HIDDEN}{end}"
        lines.append(re.sub(r"://[^/@\s]+@", f"://{HIDDEN}@", line))
    return "".join(lines)


def _versions(now: datetime) -> dict[str, object]:
    packages = {d.name: d.version for d in metadata.distributions()}
    return {
        "made": now.isoformat(timespec="seconds"),
        "clearway": packages.get("clearway"),
        "python": platform.python_version(),
        "system": platform.platform(),
        "machine": platform.machine(),
        "packages": dict(sorted(packages.items())),
    }
