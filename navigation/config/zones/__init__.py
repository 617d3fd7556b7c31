"""The list `zones` of a configuration: areas with rules, for all robots or some of them by name.

- `section` is one entry, which becomes the planner's zone.
- `zone_checks` compares the entries with each other, the robots and the arena.
- `in_words` describes an entry in a line, and writes it as in a configuration.
"""

from navigation.config.zones.section import MOST_ZONES, ZoneSection

__all__ = ["MOST_ZONES", "ZoneSection"]
