"""Bundle for a fault report: one zip with what helps to understand it.

It holds findings, versions, the configuration with the files it names, the last run's report and
picture, and the head of the newest recording. Secrets are removed everywhere, by key and by value;
a recording that contains one is left out. Of the environment only Clearway's variables are kept.
"""

from __future__ import annotations

import json
import platform
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Final

from navigation.config import Config
from navigation.config.last_good import LastGood, state_folder
from navigation.config.secrecy.secret_places import (
    log_without_secrets,
    secrets_in_environment,
    secrets_in_source,
    without_secrets,
)
from navigation.config.secrecy.secrets import HIDDEN, hide_in, is_secret_key, known, learn
from navigation.config.unknown_keys import values_of_unknown_keys
from navigation.machine.doctor import Finding

MOST_RECORDING_BYTES: Final = 20_000_000
MOST_TEXT_BYTES: Final = 20_000_000


def write_bundle(
    target: Path,
    file: Path | None,
    config: Config | None,
    findings: Iterable[Finding],
    environment: Mapping[str, str],
    now: datetime,
) -> list[str]:
    """Write the zip; return the names of its contents.

    ``file``, the configuration, may be broken: then its text is included and ``config`` is None.
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
    kept = None if file is None else LastGood(file, state_folder(environment)).kept
    learn(secrets_in_environment(environment))
    for source in filter(None, (file, kept)):
        learn(secrets_in_source(_text(source) or ""))
    told = [asdict(finding) for finding in findings]
    yield "findings.json", json.dumps(hide_in(told), indent=2)
    yield "versions.json", json.dumps(_versions(now), indent=2)
    own = {
        name: HIDDEN if is_secret_key(name) else without_secrets(value)
        for name, value in sorted(environment.items())
        if name.startswith("CLEARWAY_")
    }
    yield "environment.json", json.dumps(own, indent=2)
    if file is not None and kept is not None:
        yield from _file("configuration.yaml", file, _shown)
        yield from _file("last_good.yaml", kept, _shown)
    if config is None:
        return
    if config.camera.calibration is not None:
        yield from _file("calibration.yaml", config.camera.calibration)
    for entry in config.cameras:
        if entry.calibration is not None:
            yield from _file(f"calibration_{entry.name}.yaml", entry.calibration)
    if config.simulation is not None and config.simulation.arena is not None:
        yield from _file("arena.txt", config.simulation.arena)
    runs = sorted(folder for folder in config.recording.runs_dir.glob("*") if folder.is_dir())
    if runs:
        for one in sorted(runs[-1].iterdir()):
            if one.suffix in (".json", ".jsonl", ".svg"):
                yield from _file(f"last_run/{one.name}", one, log_without_secrets)
    yield from _newest_recording(config.recording.folder)


def _newest_recording(folder: Path) -> Iterator[tuple[str, str | bytes]]:
    """Head of the newest recording: a recording cut off there can still be replayed."""
    files = sorted(folder.glob("clearway_*.mcap"))
    if files:
        with files[-1].open("rb") as recording:
            head = recording.read(MOST_RECORDING_BYTES)
        if known().occurs_in(head):
            yield f"recording/{files[-1].name}.txt", "left out: it contains a secret\n"
        else:
            yield f"recording/{files[-1].name}", head


def _file(
    name: str, file: Path, clean: Callable[[str], str] = without_secrets
) -> Iterator[tuple[str, str]]:
    text = _text(file)
    if text is not None:
        yield name, clean(text)


def _shown(text: str) -> str:
    """Remove secrets and the values of unknown keys from a configuration."""
    return without_secrets(text, values_of_unknown_keys(text, Config))


def _text(file: Path) -> str | None:
    try:
        with file.open("rb") as source:
            return source.read(MOST_TEXT_BYTES).decode("utf-8", errors="replace")
    except OSError:
        return None


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
