"""An IFC4 file under construction: entities, ids and properties, without a word on rooms."""

import hashlib
import uuid
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..extras import optional_module

_LABEL_LENGTH = 255
"""Of an IfcLabel and an IfcIdentifier at most."""

_SPACE = uuid.UUID("6f1d3f36-5f0c-4d0b-9d2b-6f8f0f2f7a11")
"""Namespace of our ids (RFC 9562, version 5)."""


class IfcDocument:
    """A thin layer over `ifcopenshell.file`: ids that depend on nothing but the model, and short ways."""

    def __init__(self, seed: str) -> None:
        """Begin a file.

        Args:
            seed: tells models apart; the same seed gives the same global ids.

        Raises:
            OutputError: ifcopenshell is not installed.
        """
        module = optional_module("ifcopenshell", "ifc", "IFC")
        self._compress = optional_module("ifcopenshell.guid", "ifc", "IFC").compress
        self._seed = hashlib.sha256(seed.encode()).hexdigest()
        self._ids: set[str] = set()
        self.file: Any = module.file(schema="IFC4")
        self.origin = self.make("IfcCartesianPoint", (0.0, 0.0, 0.0))
        self._upright = self.make("IfcAxis2Placement3D", self.origin, None, None)
        self._colours: dict[tuple[int, int, int], Any] = {}

    def make(self, kind: str, *attributes: Any, **named: Any) -> Any:
        """A new entity, attributes in the order of the schema."""
        return self.file.create_entity(kind, *attributes, **named)

    def rooted(self, kind: str, key: str, **attributes: Any) -> Any:
        """A new entity with a global id made of its kind and a key.

        No owner history: the schema lets it go, and it holds nothing but dates and persons.
        """
        text = f"{self._seed}/{kind}/{key}"
        assert text not in self._ids, text
        self._ids.add(text)
        return self.make(
            kind, GlobalId=self._compress(uuid.uuid5(_SPACE, text).hex), OwnerHistory=None, **attributes
        )

    def placement(self, parent: Any, axes: Any = None) -> Any:
        """A local placement below another one, in its place unless axes are given."""
        return self.make("IfcLocalPlacement", parent, axes or self._upright)

    def axes(self, origin: Sequence[float], x_axis: Sequence[float] | None = None) -> Any:
        """A coordinate system with z up."""
        if x_axis is None:
            return self.make("IfcAxis2Placement3D", self._point(origin), None, None)
        up, across = (
            self.make("IfcDirection", tuple(map(float, axis))) for axis in ((0.0, 0.0, 1.0), x_axis)
        )
        return self.make("IfcAxis2Placement3D", self._point(origin), up, across)

    def relate(self, kind: str, key: str, one: tuple[str, Any], many: tuple[str, Sequence[Any]]) -> None:
        """A relation of one entity with several; nothing where there are none."""
        if many[1]:
            self.rooted(kind, key, **{one[0]: one[1], many[0]: list(many[1])})

    def properties(self, target: Any, key: str, name: str, values: dict[str, Any]) -> None:
        """A property set of a target. Values are IFC value entities, or tuples (low, value, high)."""
        properties = [self._property(label, value) for label, value in values.items()]
        holder = self.rooted("IfcPropertySet", f"{key}/{name}", Name=name, HasProperties=properties)
        relation = {"RelatedObjects": [target], "RelatingPropertyDefinition": holder}
        self.rooted("IfcRelDefinesByProperties", f"{key}/{name}", **relation)

    def quantities(self, target: Any, key: str, name: str, values: dict[str, tuple[str, float]]) -> None:
        """Base quantities of a target: by name the kind (``Length``, ``Area``, ``Volume``) and the value."""
        entities = [
            self.make(f"IfcQuantity{kind}", label, None, None, float(value))
            for label, (kind, value) in values.items()
        ]
        holder = self.rooted("IfcElementQuantity", f"{key}/{name}", Name=name, Quantities=entities)
        relation = {"RelatedObjects": [target], "RelatingPropertyDefinition": holder}
        self.rooted("IfcRelDefinesByProperties", f"{key}/{name}", **relation)

    def text(self, value: str) -> Any:
        """A text of any length as a property's value."""
        return self.make("IfcText", readable(value))

    def label(self, value: str) -> Any:
        """A short text as a property's value."""
        return self.make("IfcLabel", readable(value)[:_LABEL_LENGTH])

    def measure(self, kind: str, value: float) -> Any:
        """A number with its dimension, e.g. of kind ``Length`` or ``Ratio``."""
        return self.make(f"Ifc{kind}Measure", float(value))

    def colour(self, item: Any, rgb: tuple[int, int, int]) -> None:
        """Give a geometric item a colour."""
        if rgb not in self._colours:
            colour = self.make("IfcColourRgb", None, *(channel / 255.0 for channel in rgb))
            shading = self.make("IfcSurfaceStyleShading", colour, 0.0)
            self._colours[rgb] = self.make("IfcSurfaceStyle", None, "BOTH", [shading])
        self.make("IfcStyledItem", item, [self._colours[rgb]], None)

    def points(self, corners_m: Float[np.ndarray, "corners 3"]) -> list[Any]:
        """Corners as points."""
        return [self._point(corner) for corner in corners_m.tolist()]

    def _point(self, corner: Sequence[float]) -> Any:
        return self.make("IfcCartesianPoint", tuple(float(value) + 0.0 for value in corner))

    def _property(self, name: str, value: Any) -> Any:
        if isinstance(value, tuple):
            low, middle, high = value
            return self.make("IfcPropertyBoundedValue", name, None, high, low, None, middle)
        return self.make("IfcPropertySingleValue", name, None, value, None)


def readable(text: str) -> str:
    """A text without control characters and lone surrogates, which STEP files cannot hold."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def name_of(text: str) -> str:
    """A text as the name of an entity."""
    return readable(text)[:_LABEL_LENGTH]
