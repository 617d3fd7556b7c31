"""Commands that look at a picture or a map and drive nothing.

- `sources` reads a picture, a scene or a map into a scene.
- `extract` prints the obstacles of a picture, `markers` its markers.
- `roadmap` writes the roadmap of a source, `audit` checks a route graph.
- `plan` plans one path, `fleet` those of several robots, which `fleet_robots` reads.
- `*_answer` write the answers, `*_picture` draw them.
"""
