"""The parts of the CityJSON 2.0 specification that our files use, as a strict JSON schema of our own.

Written from the text of the specification (https://www.cityjson.org/specs/2.0.1/): only the members that it
names are allowed, where the official schema lets most others pass.
"""

NUMBERS_3 = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
EXTENT = {"type": "array", "items": {"type": "number"}, "minItems": 6, "maxItems": 6}
RING = {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 3, "uniqueItems": True}
SURFACE = {"type": "array", "items": RING, "minItems": 1}
SHELL = {"type": "array", "items": SURFACE, "minItems": 4}
INTERIOR = ["InteriorWallSurface", "FloorSurface", "CeilingSurface", "ClosureSurface", "Door", "Window"]

SEMANTICS = {
    "type": "object",
    "properties": {
        "surfaces": {
            "type": "array",
            "items": {
                "type": "object",
                "properties": {"type": {"enum": INTERIOR}},
                "required": ["type", "id", "status", "offset_std_m"],
            },
        },
        "values": {"type": "array", "items": {"type": "array", "items": {"type": ["integer", "null"]}}},
    },
    "required": ["surfaces", "values"],
    "additionalProperties": False,
}
SOLID = {
    "type": "object",
    "properties": {
        "type": {"const": "Solid"},
        # 3.1: a string, one digit or two with a point.
        "lod": {"type": "string", "pattern": r"^[0-3](\.[0-3])?$"},
        "boundaries": {"type": "array", "items": SHELL, "minItems": 1},
        "semantics": SEMANTICS,
    },
    "required": ["type", "lod", "boundaries"],
    "additionalProperties": False,
}
ROOM = {
    "type": "object",
    "properties": {
        "type": {"const": "BuildingRoom"},
        "attributes": {"type": "object"},
        "parents": {"type": "array", "items": {"type": "string"}, "minItems": 1},
        "children": {"type": "array", "items": {"type": "string"}},
        "geographicalExtent": EXTENT,
        "geometry": {"type": "array", "items": SOLID},
    },
    "required": ["type", "parents"],
    "additionalProperties": False,
}
BUILDING = {
    "type": "object",
    "properties": {
        "type": {"const": "Building"},
        "attributes": {"type": "object"},
        "children": {"type": "array", "items": {"type": "string"}},
        "geographicalExtent": EXTENT,
    },
    "required": ["type"],
    "additionalProperties": False,
}
CITYJSON = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "type": "object",
    "properties": {
        "type": {"const": "CityJSON"},
        "version": {"const": "2.0"},
        "transform": {
            "type": "object",
            "properties": {"scale": NUMBERS_3, "translate": NUMBERS_3},
            "required": ["scale", "translate"],
            "additionalProperties": False,
        },
        "metadata": {
            "type": "object",
            "properties": {
                "geographicalExtent": EXTENT,
                "identifier": {"type": "string"},
                "pointOfContact": {"type": "object"},
                "referenceDate": {"type": "string", "format": "date"},
                "referenceSystem": {"type": "string", "pattern": r"^https?://www\.opengis\.net/def/crs/"},
                "title": {"type": "string"},
            },
            "additionalProperties": False,
        },
        "CityObjects": {"type": "object", "additionalProperties": {"oneOf": [ROOM, BUILDING]}},
        "vertices": {
            "type": "array",
            "items": {"type": "array", "items": {"type": "integer"}, "minItems": 3, "maxItems": 3},
        },
    },
    "required": ["type", "version", "transform", "CityObjects", "vertices"],
    "additionalProperties": False,
}
