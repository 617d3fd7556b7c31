"""Several cameras over one arena: their pictures as one, what none of them sees, poses fused.

Each camera is calibrated to the same floor. `floor_plan` lays that floor out as one picture.
`outline_agreement` measures how far two cameras' outlines lie apart, `pose_fusion` makes one pose
of several sightings of a marker.
"""
