"""The mission meant for the robot: given, followed to its end, or void.

It is void after a reboot, an emergency stop, or a report of other waypoints. Its id is not reused:
part of it may have been driven.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from firmware_protocol.host.events import Event, MissionAccepted, MissionDone, MissionVoid
from firmware_protocol.host.state import LinkEvent
from firmware_protocol.host.upload import Upload
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.messages import Status
from firmware_protocol.wire.mission import Mission


class WantedMission:
    """At most one mission; ``tell`` takes events for the user, ``change`` the link's."""

    def __init__(
        self, tell: Callable[[Event], None], change: Callable[[LinkEvent, str], None]
    ) -> None:
        self.upload: Upload | None = None
        self._tell, self._change = tell, change
        self._void_ids: deque[int] = deque(maxlen=64)

    def give(self, mission: Mission) -> Upload:
        """Replace the mission; LocalError for a void one's id."""
        if mission.id in self._void_ids:
            raise LocalError(f"mission {mission.id} became void: a new one needs a new id")
        self.upload = Upload(mission)
        return self.upload

    def follow(self, upload: Upload, status: Status, credit: int, everything: bool) -> str | None:
        """Follow the mission by a report; return a sentence if that voids it.

        ``everything``: the report follows every frame sent.
        """
        was_done = upload.done
        void = upload.see_status(status, credit, everything)
        if void is not None:
            return void
        if upload.complete and not upload.announced:
            upload.announced = True
            self._tell(MissionAccepted(upload.mission.id))
        if upload.complete and not upload.done:
            self._change(LinkEvent.ALL_ACCEPTED, "the robot has the whole mission")
        if upload.done and not was_done:
            self._tell(MissionDone(upload.mission.id))
            self._change(LinkEvent.MISSION_OVER, "the mission is done")
        return None

    def void(self, reason: str) -> None:
        """Make the mission void."""
        assert self.upload is not None
        self._tell(MissionVoid(self.upload.mission.id, reason))
        self._void_ids.append(self.upload.mission.id)
        self.upload = None
