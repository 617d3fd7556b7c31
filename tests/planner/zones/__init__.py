"""Zones: areas, rules, plans of one robot and of several."""
