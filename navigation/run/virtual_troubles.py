"""What may go wrong in virtual time on order: camera, cable, port, and what people do.

Metres, radians.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

from navigation.run.troubled_camera import CameraTroubles


@dataclass(slots=True)
class Troubles(CameraTroubles):
    """What a test may switch while a run goes on; everything is well in the beginning."""

    port_broken: bool = False
    """The port is gone: nothing passes, and it cannot be opened."""
    cable_out: bool = False
    """Nothing passes in either direction, without an error."""
    carried_to: tuple[float, float, float] | None = None
    """Somebody takes the robot and puts it there, once."""
    stuck: bool = False
    """The wheels turn and the robot stays where it is."""
    cameras: defaultdict[str, CameraTroubles] = field(
        default_factory=lambda: defaultdict(CameraTroubles)
    )
    """Of several cameras, by name; what the picture shows of the robot is the same in all."""
