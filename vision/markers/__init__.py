"""From a picture to the poses of robots: markers found, refined, identified and tracked.

- `marker_search` finds quadrilaterals with a code in a picture, unrefined.
- `marker_corners` (loops in `marker_kernels`) fits and intersects a marker's sides.
- `marker_pattern` describes the fit of the whole pattern: `marker_place_kernels` calls
  `marker_pattern_kernels` for it and `marker_agreement_kernels` for the check.
- `marked_robot`: a marker's pose and its robot's.
- `sighting` finds one robot's marker, `tracking` makes a track of its sightings.
- `markers` does this for known robots, frame after frame; `reading` reads every marker in a
  picture.
"""
