"""Commands that look at a picture or a map and drive nothing.

- ``sources.py`` reads a picture, a scene or a map into a scene.
- ``extract.py`` prints the obstacles of a picture, ``markers.py`` its markers.
- ``roadmap.py`` writes the roadmap of a source.
- ``audit.py`` checks a route graph: ``audit_answer.py`` writes the answer and
  ``audit_picture.py`` draws it.
- ``plan.py`` plans one path; ``plan_answer.py`` writes the answer.
- ``fleet.py`` plans several robots: ``fleet_robots.py`` reads them, ``fleet_answer.py`` writes the
  answer and ``fleet_picture.py`` draws it.
"""
