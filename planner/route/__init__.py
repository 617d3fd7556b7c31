"""From a request to a path, or the reasons for a refusal.

- ``plan_request.py`` parses the request, ``margin.py`` leads out of the margin.
- ``route.py`` plans each leg over the chains; ``taut.py``, ``taut_kernels.py`` and
  ``corridor_kernels.py`` turn routes into proved polylines.
- ``hysteresis.py`` keeps the last path, ``whole_path.py`` joins the legs.
- ``no_way.py`` explains why there is no path.
"""
