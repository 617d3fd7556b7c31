"""No outgoing text shows a token or a camera's password, however the configuration writes it."""

from __future__ import annotations

import base64
import io
import json
import re
import time
import zipfile
from datetime import datetime
from pathlib import Path
from typing import Any
from urllib.parse import quote, quote_plus

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.config import ConfigError, parse_config
from navigation.config.last_good import LastGood
from navigation.config.reference import json_schema
from navigation.config.secrecy import secrets
from navigation.config.secrecy.secret_places import masked, secrets_in_source, without_secrets
from navigation.config.secrecy.secrets import HIDDEN, Redactor, hide, hide_in, learn
from navigation.machine.bundle import write_bundle
from navigation.machine.logs import EventLog
from navigation.recording.json_bodies import configuration_body
from tests.support.pictures import call
from tests.support.runs.virtual import short_config

TOKEN = "s3cr3t-t0ken.of_16~chars"
PASSWORD = "geh eim/4711@%"
ADDRESS = "rtsp://me:geh%20eim%2F4711%40%25@camera.local:554/live"


FORMS = {
    "plain": "dashboard:\n  token: TOKEN\n",
    "quoted": 'dashboard:\n  token: "TOKEN"\n',
    "single quoted": "dashboard:\n  token: 'TOKEN'   # ours\n",
    "flow": "dashboard: {port: 1, token: TOKEN, host: a}\n",
    "flow of json": '{"dashboard": {"token": "TOKEN", "port": 1}}\n',
    "next line": "dashboard:\n  token:\n    TOKEN\n",
    "next line of flow": "dashboard: {token:\n  TOKEN}\n",
    "folded": "dashboard:\n  token: >-\n    TOKEN\n  port: 1\n",
    "literal": "dashboard:\n  token: |\n    TOKEN\n\n  port: 1\n",
    "folded in two": "dashboard:\n  token: >-\n    TOKEN\n    MORE-OF-IT\n",
    "anchor": "dashboard:\n  token: &t TOKEN\n  viewer_token: *t\n",
    "alias": "arena: &t TOKEN\ndashboard:\n  token: *t\n",
    "tagged": "dashboard:\n  token: !!str TOKEN\n",
    "explicit key": "dashboard:\n  ? token\n  : TOKEN\n",
    "a list of them": "dashboard:\n  tokens: [TOKEN, MORE-OF-IT]\n",
    "twice": "dashboard:\n  token: MORE-OF-IT\n  token: TOKEN\n",
    "in a comment": "# TOKEN was mine\ndashboard:\n  token: TOKEN\n",
    "in a comment alone": "# old token: TOKEN\narena: 1\n",
    "escaped": 'dashboard:\n  token: "' + "".join(f"\\x{ord(c):02x}" for c in TOKEN) + '"\n',
    "under another section": "arena:\n  passwords:\n    mine: TOKEN\n",
}
BROKEN = {
    "": "",
    "a tab": "\tarena: [\n",
    "an open bracket": "arena: [1, 2\n",
    "an open quote": "\narena: 'never closed\n",
    "two documents": "\n---\na: 1\n",
    "an unknown alias": "\narena: *nobody\n",
}


@pytest.mark.parametrize("broken", BROKEN)
@pytest.mark.parametrize("form", FORMS)
def test_a_configuration_s_text_is_left_without_its_secrets(form: str, broken: str) -> None:
    text = (FORMS[form] + BROKEN[broken]).replace("TOKEN", TOKEN)
    for clean in (without_secrets(text), masked(text)):
        assert TOKEN not in clean
        assert "MORE-OF-IT" not in clean
    assert masked(text).count("\n") == text.count("\n")
    for line, clean in zip(text.splitlines(), masked(text).splitlines(), strict=True):
        assert len(line) == len(clean)


@pytest.mark.parametrize("broken", BROKEN)
@pytest.mark.parametrize("form", [f for f in FORMS if f not in ("in a comment alone",)])
def test_an_error_s_text_never_shows_a_secret_and_what_was_read_is_learned(
    form: str, broken: str
) -> None:
    text = (FORMS[form] + BROKEN[broken]).replace("TOKEN", TOKEN)
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "a.yaml")
    assert TOKEN not in str(caught.value)
    assert "MORE-OF-IT" not in str(caught.value)
    if form != "escaped" or not broken:
        assert TOKEN not in hide(f"the page says {TOKEN}")


def test_an_address_s_user_and_password_are_left_out_of_what_is_shown() -> None:
    text = f"camera:\n  source: {ADDRESS}\n"
    assert without_secrets(text) == f"camera:\n  source: rtsp://{HIDDEN}@camera.local:554/live\n"
    assert {PASSWORD, "geh%20eim%2F4711%40%25"} <= secrets_in_source(text)


@given(st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=4))
def test_every_form_of_a_secret_is_found(secret: str) -> None:
    redactor = Redactor([secret])
    for form in (
        secret,
        quote(secret),
        quote(secret, safe=""),
        re.sub("%..", lambda m: m.group().lower(), quote(secret, safe="")),
        quote_plus(secret),
        json.dumps(secret)[1:-1],
        json.dumps(secret, ensure_ascii=False)[1:-1],
        base64.b64encode(secret.encode()).decode(),
    ):
        assert redactor.text(f" {form} ") == f" {HIDDEN} "


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("rtsp://me:pw@host/a is gone", f"rtsp://{HIDDEN}@host/a is gone"),
        ("rtsp://me:se/cr@et@host/live", f"rtsp://{HIDDEN}@host/live"),
        ("http://host/a@b", "http://host/a@b"),
        ("http://host:80/a@b", "http://host:80/a@b"),
        (
            "http://host/a?user=me&pwd=geheim&x=1 is gone",
            f"http://host/a?user={HIDDEN}&pwd={HIDDEN}&x={HIDDEN} is gone",
        ),
        ("http://host/a?geheim", f"http://host/a?{HIDDEN}"),
        ("http://host/a?x=1;geheim&geheim==", f"http://host/a?x={HIDDEN};{HIDDEN}&{HIDDEN}"),
        ("order/a?pwd=geheim&x=1", f"order/a?pwd={HIDDEN}&x=1"),
        ("at 12.5 s: held", "at 12.5 s: held"),
    ],
)
def test_addresses_are_shown_without_their_secrets(text: str, shown: str) -> None:
    assert hide(text) == shown


def test_keys_and_numbers_of_plain_data_stay() -> None:
    learn(["token-1234"])
    assert hide_in({"token-1234": [1.5, None, True, "a token-1234"]}) == {
        "token-1234": [1.5, None, True, f"a {HIDDEN}"]
    }


def test_short_values_do_not_take_the_words_of_every_sentence() -> None:
    learn(["a", "an", "the"])
    assert hide("an angle of the arena") == "an angle of the arena"


@pytest.mark.parametrize(
    ("name", "value", "secret"),
    [
        ("CLEARWAY_DASHBOARD__TOKEN", TOKEN, TOKEN),
        ("CLEARWAY_CAMERA__SOURCE", ADDRESS, "geh%20eim"),
        ("CLEARWAY_DASHBOARD", f"{{token: {TOKEN}}}", TOKEN),
    ],
)
def test_the_environment_s_secrets_are_in_no_bundle_and_in_no_log(
    tmp_path: Path, name: str, value: str, secret: str
) -> None:
    (tmp_path / "a.yaml").write_text("arena: 1\n")
    environment = {name: value, "XDG_STATE_HOME": str(tmp_path), "HOME": "/root"}
    target = tmp_path / "bundle.zip"
    write_bundle(target, tmp_path / "a.yaml", None, [], environment, datetime(2026, 1, 1))
    for text in texts_of(target):
        assert secret not in text
    stream = io.StringIO()
    log = EventLog(stream, "json", now=lambda: datetime(2026, 1, 1))
    log.write("info", "said", reason=f"the value is {value}", more=[value])
    assert secret not in stream.getvalue()


def texts_of(bundle: Path) -> list[str]:
    with zipfile.ZipFile(bundle) as archive:
        return [archive.read(name).decode(errors="replace") for name in archive.namelist()]


@pytest.mark.parametrize("form", FORMS)
def test_a_bundle_shows_no_secret_of_the_configuration_anywhere(tmp_path: Path, form: str) -> None:
    text = FORMS[form].replace("TOKEN", TOKEN) + f"camera: {{source: '{ADDRESS}'}}\n"
    (tmp_path / "a.yaml").write_text(text)
    call("doctor", tmp_path / "a.yaml", "--bundle", tmp_path / "b.zip")
    for shown in texts_of(tmp_path / "b.zip"):
        assert TOKEN not in shown
        assert "geh%20eim" not in shown
        assert "MORE-OF-IT" not in shown


def test_a_bundle_leaves_out_a_recording_in_which_a_secret_stands(tmp_path: Path) -> None:
    config = short_config([])
    folder = tmp_path / "recordings"
    folder.mkdir()
    (folder / "clearway_1.mcap").write_bytes(b"binary " + TOKEN.encode())
    recording = config.recording.model_copy(
        update={"folder": folder, "runs_dir": tmp_path / "runs"}
    )
    config = config.model_copy(update={"recording": recording})
    (tmp_path / "a.yaml").write_text(f"dashboard: {{token: {TOKEN}}}\n")
    write_bundle(
        tmp_path / "b.zip", tmp_path / "a.yaml", config, [], {"HOME": "/"}, datetime(2026, 1, 1)
    )
    assert not any(TOKEN in text for text in texts_of(tmp_path / "b.zip"))


def test_check_shows_an_address_without_its_password(config_file: Path) -> None:
    text = config_file.read_text().replace("source: simulated", f"source: '{ADDRESS}'")
    config_file.write_text(text)
    told = call("check", config_file)
    assert told.code == 0, told
    assert f"rtsp://{HIDDEN}@camera.local" in told.out
    assert "geh" not in told.out


def test_a_traceback_shows_no_secret(config_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> None:
        raise RuntimeError(f"no answer from {ADDRESS} with {TOKEN}")

    learn([TOKEN])
    monkeypatch.setattr("navigation.cli.setup.check.load_checked", fails)
    told = call("--debug", "check", config_file)
    assert "Traceback" in told.err
    assert TOKEN not in told.err
    assert "geh" not in told.err


def test_a_recording_s_configuration_holds_no_secret() -> None:
    config = short_config([])
    config = config.model_copy(
        update={"serial": config.serial.model_copy(update={"port": "rfc2217://me:geheim@host:1"})}
    )
    body = configuration_body(config, "", "1", 1, 0.0, 0)
    assert "geheim" not in json.dumps(body)


def test_a_recording_s_configuration_holds_no_value_of_a_camera_s_query() -> None:
    config = short_config([])
    source = "http://me:geheim@camera.local/mjpg?token=s3cret1&t=s3cret2;naked-s3cret3#s3cret4"
    config = config.model_copy(
        update={"camera": config.camera.model_copy(update={"source": source})}
    )
    text = json.dumps(configuration_body(config, "", "1", 1, 0.0, 0))
    assert "s3cret" not in text
    assert "geheim" not in text
    assert "camera.local/mjpg?token=" in text


@given(
    st.text("ab:/?#&;=@% '()", max_size=12),
    st.sampled_from(["", "key=", "t=", "token=abcd&x="]),
    st.text("abc(left out)&;=", max_size=20),
)
def test_what_was_left_out_once_is_left_out_the_same_way_again(
    before: str, name: str, value: str
) -> None:
    redactor = Redactor(["abcd"])
    for text in (f"http://host/{before}?{name}{value}", f"{before}?{name}{value}"):
        once = redactor.text(text)
        assert redactor.text(once) == once


@pytest.mark.parametrize(
    "piece", ["x", "token", "token: '", "token: &", "#", " # token", "://a:b", "?pass", "a: &t\n"]
)
def test_no_text_takes_long_to_be_cleaned(piece: str) -> None:
    """What takes a second for a thousand pieces would take days for a whole file of them."""
    text = "a: " + piece * (100_000 // len(piece))
    began_s = time.process_time()
    without_secrets(text)
    hide(text)
    assert time.process_time() - began_s < 8.0


MISTYPED = {
    "block": "dashboard:\n  tokn: TOKEN\n",
    "flow, with another error": "dashboard: {port: none, tokn: TOKEN}\n",
    "near no secret's name": "dashboard: {port: none, colour: TOKEN}\n",
    "twice": "dashboard:\n  colour: 1\n  colour: TOKEN\n",
    "below it": "dashboard:\n  tokenn:\n    - TOKEN\n",
    "a section": "dashbord: {port: 1, token: TOKEN, colour: TOKEN}\n",
    "in another's place": "planning: {port: TOKEN}\n",
    "not YAML": "dashboard: {port: [1, tokn: TOKEN}\n",
}


@pytest.mark.parametrize("form", MISTYPED)
def test_the_value_of_an_unknown_key_is_shown_by_no_error(form: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_config(MISTYPED[form].replace("TOKEN", TOKEN), "a.yaml")
    assert TOKEN not in str(caught.value)


def test_a_mistyped_secret_is_learned_and_its_right_name_is_said() -> None:
    text = MISTYPED["block"].replace("TOKEN", TOKEN)
    with pytest.raises(ConfigError, match=r"dashboard\.tokn: .*did you mean 'token'"):
        parse_config(text, "a.yaml")
    assert TOKEN not in hide(f"the page says {TOKEN}")
    assert TOKEN not in without_secrets(text)


@pytest.mark.parametrize("command", ["check", "run", "doctor", "plan", "calibrate"])
def test_no_command_shows_the_value_of_a_mistyped_key(config_file: Path, command: str) -> None:
    text = config_file.read_text() + f"\ndashbord: {{tokn: {TOKEN}, colour: {TOKEN}}}\n"
    config_file.write_text(text)
    told = call(command, config_file)
    assert TOKEN not in told.out + told.err


def test_the_changes_since_the_last_good_configuration_show_no_value_of_an_unknown_key(
    config_file: Path, tmp_path: Path
) -> None:
    kept, good = LastGood(config_file, tmp_path), config_file.read_text()
    assert kept.keep(good) is None
    config_file.write_text(good + f"\ndashbord: {{colour: {TOKEN}}}\n")
    advice = str(kept.advice())
    assert "dashbord: " in advice
    assert TOKEN not in advice


def test_a_bundle_shows_no_value_of_an_unknown_key(config_file: Path, tmp_path: Path) -> None:
    good = config_file.read_text()
    config_file.write_text(good + f"\ndashbord: {{colour: {TOKEN}}}\n")
    told = call("doctor", config_file, "--bundle", tmp_path / "b.zip")
    for text in (told.out, told.err, *texts_of(tmp_path / "b.zip")):
        assert TOKEN not in text


def test_no_key_of_a_configuration_is_taken_for_a_mistyped_secret() -> None:
    names = set(re.findall(r'"([a-z_0-9]+)":', json.dumps(json_schema())))
    assert {name for name in names if secrets.is_secret_key(name)} == {
        "token",
        "viewer_token",
        "supervisor_token",
        "url",
    }


@pytest.mark.parametrize(
    "fragment", ["token=geheim", "geheim", "t=geheim?x=geheim", "(left out)geheim"]
)
def test_an_address_s_fragment_is_left_out(fragment: str) -> None:
    for address in ("rtsp://host/live", "http://me:pw@host:8080/a?x=1"):
        text = f"{address}#{fragment}"
        assert "geheim" not in hide(f"{text} is gone")
        assert "geheim" not in masked(f"camera: {{source: '{text}'}}\n")
        assert hide(hide(text)) == hide(text)
