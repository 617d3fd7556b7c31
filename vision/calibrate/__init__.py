"""Making a calibration: pictures of a board give the lens, surveyed points the floor.

- `sheet` prints boards and markers at true size; `board` finds a board in pictures.
- `live` takes the pictures while somebody holds the board.
- `suspects` names views that contradict the others, by the residuals of `left_out`.
- `lens` fits Brown's model or, by `fisheye`, the fisheye's; `lens_choice` picks one of them.
- `covariance` gives the precision of a lens across the picture; it guides `live`.
- `survey` fits the arena's homography to surveyed points or to a board on the floor.
- `reanchor` repairs the calibration of a moved camera by floor markers alone.
"""
