"""Two witnesses of one motion: the camera's sight, and the wheels' turning.

The robot's reports become a track of its wheels (``wheels``). ``latency`` finds the pictures' age,
as the shift at which camera and wheels move alike; ``agreement`` finds where they differ by more
than both errors allow, and how far they have agreed; ``witness`` feeds both and gives one
`Evidence` (``evidence``) a cycle. The pilot decides on it: `navigation.mission.trust` has the
rules.

Nothing here opens anything or reads a clock. Metres, radians, seconds.
"""

from navigation.witness.evidence import NO_EVIDENCE, Evidence
from navigation.witness.witness import Witness, WitnessLimits

__all__ = ["NO_EVIDENCE", "Evidence", "Witness", "WitnessLimits"]
