"""A graph in each format that is read, with members that a reader does not know."""

from __future__ import annotations

import json

NAV2 = {
    "type": "FeatureCollection",
    "name": "hall",
    "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}},
    "date_generated": "Tue Feb 22",
    "features": [
        {
            "type": "Feature",
            "properties": {
                "id": 0,
                "frame": "hall",
                "metadata": {"class": "room", "inside": {"deep": [1, 2]}},
                "operations": {"pause": {"type": "wait", "trigger": "NODE"}},
            },
            "geometry": {"type": "Point", "coordinates": [1.5, -2.25]},
        },
        {
            "type": "Feature",
            "bbox": [0, 0, 1, 1],
            "properties": {"id": 1, "note": None},
            "geometry": {"type": "Point", "coordinates": [4, 5, 0.5]},
        },
        {
            "type": "Feature",
            "properties": {
                "id": 2,
                "startid": 0,
                "endid": 1,
                "cost": 3.5,
                "overridable": False,
                "metadata": {
                    "speed_limit": 85,
                    "abs_speed_limit": 0.4,
                    "length": 7.7,
                    "class": "aisle",
                },
            },
            "geometry": {"type": "MultiLineString", "coordinates": [[[1.5, -2.25], [4, 5]]]},
        },
        {
            "type": "Feature",
            "properties": {"id": 3, "startid": 1, "endid": 0},
            "geometry": {"type": "LineString", "coordinates": [[4, 5, 1], [1.5, -2.25]]},
        },
        {
            "type": "Feature",
            "properties": {"id": 3, "startid": 1, "endid": 7, "metadata": {"speed_limit": "low"}},
            "geometry": {
                "type": "MultiLineString",
                "coordinates": [[[4, 5], [5, 5]], [[5, 5], [6, 5], [7, 7]]],
            },
        },
        {
            "type": "Feature",
            "properties": {},
            "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [0, 1], [0, 0]]]},
        },
    ],
}
LIF = {
    "metaInformation": {"projectIdentification": "p", "creator": "c", "lifVersion": "1.0.0"},
    "more": [1, {"a": None}],
    "layouts": [
        {
            "layoutId": "ground",
            "layoutLevelId": "0",
            "nodes": [
                {
                    "nodeId": "a",
                    "mapId": "m1",
                    "nodePosition": {"x": 1, "y": 2.5, "z": 3},
                    "vehicleTypeNodeProperties": [{"vehicleTypeId": "v", "theta": 1.57}],
                },
                {"nodeId": "b", "nodePosition": {"x": -1, "y": 0}},
            ],
            "edges": [
                {
                    "edgeId": "ab",
                    "startNodeId": "a",
                    "endNodeId": "b",
                    "vehicleTypeEdgeProperties": [
                        {"vehicleTypeId": "v", "rotationAllowed": False, "maxSpeed": 1.5},
                        {"vehicleTypeId": "w", "rotationAllowed": True, "maxSpeed": 0.5},
                    ],
                }
            ],
            "stations": [{"stationId": "s", "interactionNodeIds": ["a"]}],
        },
        {"layoutId": "upper", "nodes": [], "edges": [], "stations": []},
    ],
}
RMF = """
building_name: hall
doors: {d1: {map: L1, endpoints: [[0, 0], [1, 0]]}}
levels:
  L1:
    lanes:
    - [0, 1, {orientation_constraint: forward, speed_limit: 0.5}]
    - [1, 0, {}]
    vertices:
    - [1e-3, -2.0, {name: '', is_charger: true}]
    - [3, 4, {name: lounge}]
  2:
    vertices:
    - [0.0, 0.5, {name: up}]
    lanes: []
    elevation: 3.0
"""
NODE_LINK = {
    "directed": True,
    "multigraph": False,
    "graph": {"radius": 0.3},
    "nodes": [
        {"id": 0, "x": 1.0, "y": 2.0, "owners": [1, 2]},
        {"id": "door", "pos": [3, 4], "frame": "hall"},
    ],
    "links": [
        {
            "source": 0,
            "target": "door",
            "length": 2.9,
            "speed": 0.5,
            "polyline": [[1, 2], [2, 2], [3, 4]],
            "colour": "red",
        }
    ],
}
GRAPHML = """<?xml version="1.0"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
<key id="x" for="node" attr.name="x" attr.type="double"/>
<key id="y" for="node" attr.name="y" attr.type="double"/>
<key id="w" for="edge" attr.name="weight" attr.type="double"><default>1.5</default></key>
<key id="l" for="edge" attr.name="length" attr.type="float"/>
<key id="ok" for="edge" attr.name="open" attr.type="boolean"/>
<graph edgedefault="directed">
<node id="a&amp;b"><data key="x">1</data><data key="y">-2.5e-3</data></node>
<node id="c"><data key="x">3</data><data key="y">4</data></node>
<edge source="a&amp;b" target="c" id="e"><data key="l">5</data><data key="ok">true</data></edge>
<edge source="c" target="a&amp;b" directed="false"/>
</graph></graphml>"""
TEXTS = {
    "nav2": json.dumps(NAV2),
    "lif": json.dumps(LIF),
    "rmf": RMF,
    "node-link": json.dumps(NODE_LINK),
    "graphml": GRAPHML,
}
