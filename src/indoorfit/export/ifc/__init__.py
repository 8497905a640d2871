"""IFC4 (ISO 16739-1), by ifcopenshell."""

from .building import write_ifc as write_ifc
