"""The section `notify`: a command without a shell or an address, and what it must not be."""

from __future__ import annotations

from pathlib import Path

import pytest

from navigation.cli.main import run
from navigation.config import Config, ConfigError, parse_config
from navigation.config.editing.form import form_keys
from navigation.config.secrecy.secrets import hide
from tests.navigation.config.texts import GOOD


def notified(section: str, **environment: str) -> Config:
    return parse_config(f"{GOOD}\nnotify: {section}\n", "a.yaml", environment=environment)


def test_without_the_section_nothing_is_called() -> None:
    section = parse_config(GOOD, "a.yaml").notify
    assert (section.command, section.url) == (None, None)


def test_a_command_is_a_list_and_an_address_a_text() -> None:
    section = notified("{command: [notify-send, '{robot}: {state}', '{\"a\": 1}', '{ x }']}").notify
    assert section.command == ("notify-send", "{robot}: {state}", '{"a": 1}', "{ x }")
    assert notified("{url: 'https://example.org/hook?key=1'}").notify.url is not None
    assert notified("{}", CLEARWAY_NOTIFY__WITHIN_S="2.5").notify.within_s == 2.5


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ("{command: 'notify-send it'}", "notify.command"),
        ("{command: []}", "notify.command"),
        ("{command: ['']}", "notify.command[0]"),
        ("{command: [a, '{sentense}']}", "'{sentense}' must be {state}, {robot}, {sentence} or"),
        ('{command: [a, "b\\0c"]}', "zero byte"),
        ("{command: [a, 7]}", "notify.command[1]"),
        ("{command: [a], url: 'http://example.org/'}", "must not be given beside notify.command"),
        ("{url: example.org/hook}", "must be the whole address of a web page"),
        ("{url: 'file:///etc/passwd'}", "must be the whole address of a web page"),
        ("{url: 'http://'}", "must be the whole address of a web page"),
        ("{url: 'http://example.org:0/'}", "must be the whole address of a web page"),
        ("{url: 'http://example.org:99999/'}", "must be the whole address of a web page"),
        ("{url: 'http://[::1/'}", "must be the whole address of a web page"),
        ('{url: "http://example.org/a\\r\\nX: y"}', "must be the whole address of a web page"),
        ("{url: 'http://example.org/a b'}", "must be the whole address of a web page"),
        ("{url: 'http://me:xyzzy@example.org/'}", "must not have a user or password"),
        ("{within_s: 0}", "notify.within_s"),
        ("{within_s: 61}", "notify.within_s"),
        ("{shell: true}", "notify.shell"),
    ],
)
def test_anything_else_is_refused(section: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        notified(section)
    assert said in str(caught.value)


def test_an_address_is_a_secret_in_every_text() -> None:
    url = "https://hooks.example.org/services/T0/B0/xyzzy-1234"
    notified(f"{{url: '{url}'}}")
    assert "xyzzy" not in hide(f"posting to {url} failed")
    with pytest.raises(ConfigError) as caught:
        notified("{url: 'ftp://hooks.example.org/plugh-5678'}")
    assert "plugh" not in str(caught.value)


def test_the_page_only_shows_what_is_called() -> None:
    keys = [key for key in form_keys(GOOD) if key.where[0] == "notify"]
    assert len(keys) == 3
    assert all("is changed in the file" in key.only_shown for key in keys)


@pytest.mark.parametrize("program", ["no-such-program-here", "/nowhere/at-all", __file__])
def test_a_program_that_cannot_be_run_is_said_before_the_run(
    program: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "clearway.yaml"
    assert run(["init", str(file)]) == 0
    text = file.read_text().replace("# command:", f"command: [{program}]  #")
    file.write_text(text)
    for command in (["check", str(file)], ["run", str(file), "--once"]):
        capsys.readouterr()
        assert run(command) == 78
        err = capsys.readouterr().err
        assert f"notify.command: {program}: there is no such program" in err
        assert err.count("clearway.yaml:") == 1
    file.write_text(text.replace(program, "sh"))
    assert run(["check", str(file)]) == 0
