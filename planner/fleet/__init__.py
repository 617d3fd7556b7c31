"""Several robots on one roadmap: timed tracks, no two of which ever touch.

``places`` lays the graph that the robots share over the roadmap, ``team`` holds the robots on it.
``solver`` plans one robot after the other among the moves of those before it
(``interval_search_kernels``, exact by ``motion_kernels``) and shortens the whole; where that finds
nothing, ``joint_search`` moves all at once and ends with a plan or the proof that it has none.
``fleet_plan`` holds the answer, which ``fleet_search`` checks before it is given out, and
``dependencies`` says who passes before whom. ``on_graph`` and ``on_roadmap`` are the doors.
"""
