"""The calibration's addresses: operators only, and a run without a bench names the command."""

from __future__ import annotations

import pytest

from tests.navigation.dashboard.site import TOKEN, VIEWER, Site
from tests.support.runs.shown import FakeDaemon, shown_config

LOOKED_AT = ("", "/picture.jpg")
ORDERED = ("/start", "/save", "/cancel")


@pytest.mark.parametrize(
    ("token", "code"), [("", 401), (VIEWER, 403), ("wrong-token-of-length", 403), (TOKEN, 404)]
)
def test_the_addresses_are_for_operators_and_say_where_nothing_is_calibrated(
    token: str, code: int
) -> None:
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    with Site(FakeDaemon(shown_config(token=TOKEN, viewer_token=VIEWER))) as site:
        answers = [site.get(f"/api/calibration{one}", **headers) for one in LOOKED_AT]
        answers += [site.get(f"/api/calibration{one}", "POST", b"{}", **headers) for one in ORDERED]
    assert {answer[0] for answer in answers} == {code}
    says = ["clearway calibrate --live" in answer[1] for answer in answers]
    assert says == [token == TOKEN] * len(answers)
