"""``clearway devices`` lists what there is, and says so where there is nothing."""

from __future__ import annotations

import json

import pytest

from navigation.cli.main import run
from navigation.cli.setup import devices


def test_what_there_is_is_listed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    port = {"path": "/dev/serial/by-id/usb-robot", "device": "/dev/ttyUSB0", "name": "Robot"}
    camera = {"path": "/dev/v4l/by-id/usb-cam-index0", "name": "Cam"}
    monkeypatch.setattr(devices, "serial_ports", lambda: [port])
    monkeypatch.setattr(devices, "cameras_here", lambda: [camera])
    assert run(["devices"]) == 0
    text = capsys.readouterr().out
    assert "/dev/serial/by-id/usb-robot  Robot" in text
    assert "/dev/v4l/by-id/usb-cam-index0  Cam" in text
    assert run(["devices", "--format", "json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert listed == {"schema": "clearway.devices/1", "serial": [port], "cameras": [camera]}


def test_nothing_is_said_to_be_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(devices, "serial_ports", list)
    monkeypatch.setattr(devices, "cameras_here", list)
    assert run(["devices"]) == 0
    assert capsys.readouterr().out == "serial ports: none\ncameras: none\n"


def test_this_machine_s_devices_are_listed_without_an_error(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["devices", "--format", "json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    for device in [*listed["serial"], *listed["cameras"]]:
        assert device["path"].startswith("/")
        assert device["name"]
