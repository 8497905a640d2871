"""Names of the formats that a model is written in: here, for the command line must not load the writers."""

from typing import Literal

FormatName = Literal[
    "glb",
    "vrml",
    "x3d",
    "obj",
    "ply",
    "stl",
    "3mf",
    "dae",
    "ifc",
    "cityjson",
    "dxf",
    "pdf",
    "svg",
    "png",
    "csv",
]
