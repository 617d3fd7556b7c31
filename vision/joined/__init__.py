"""Several cameras over one arena: their pictures as one, what none of them sees, poses fused.

Each camera is calibrated to the same floor. `floor_plan` lays that floor out as one picture, in
which every place is shown by the camera that knows best where it lies; from there on an arena of
several cameras is an arena of one. `agreement` says how far two cameras' outlines lie apart,
`pose_fusion` makes one pose of what several of them saw of a marker.
"""
