"""The plan as DXF, by ezdxf."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.export import dimension_facts, face_facts, model_facts, one_line, optional_module, room_facts
from indoorfit.model import FitResult

from .arrows import SIZE, Placement, Span, extension_start
from .display import CAP_HEIGHT, Box, Label
from .layout import Layout
from .outline import BAND, WallLine

APP_ID = "INDOORFIT"
"""Of the extended data: keys and values in turn."""

_METRES = 6
"""$INSUNITS."""

_STYLE = "INDOORFIT"
_LAYERS = {
    "WALLS": 7,
    "WALLS_INFERRED": 30,
    "STEPS": 8,
    "FLOORS": 8,
    "CEILINGS": 9,
    "DIMENSIONS": 150,
    "DIMENSIONS_INFERRED": 30,
    "NAMES": 8,
    "NOTES": 8,
}
"""Names and AutoCAD colour numbers."""

_STRING_BYTES = 250
"""Of a string in extended data, 255 at the most."""


def to_dxf(result: FitResult, layout: Layout) -> bytes:
    """The plan in metres: walls, floors, names, and the dimensions as entities that measure again.

    Coordinates are Manhattan x and y, near the origin with the axes along the walls; the pose in the scan
    is in the file's custom properties and its notes. Ids, status and intervals are extended data of the
    entities. Letters are sized for the layout's scale.

    Args:
        result: what to draw.
        layout: at a scale on paper.

    Raises:
        OutputError: ezdxf is not installed.
    """
    ezdxf = optional_module("ezdxf", "plan", "DXF")
    with _without_dates(ezdxf.options):
        drawing = _Drawing(ezdxf, layout)
        drawing.outline(result)
        for placement in layout.placements:
            drawing.dimension(result, placement)
        drawing.texts()
        drawing.notes(result)
        return drawing.content()


@contextmanager
def _without_dates(options: Any) -> Iterator[None]:
    """Dates and ids of the file fixed, so that the same plan gives the same bytes."""
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


class _Drawing:
    def __init__(self, ezdxf: Any, layout: Layout) -> None:
        self._ezdxf = ezdxf
        self._layout = layout
        self._unit_m = 1.0 / layout.outline.scale
        self._doc = ezdxf.new("R2010", units=_METRES)
        self._doc.header["$MEASUREMENT"] = 1
        self._doc.appids.add(APP_ID)
        self._doc.linetypes.add("INFERRED", [0.6, 0.4, -0.2])
        self._doc.styles.add(_STYLE, font="arial.ttf")
        for name, colour in _LAYERS.items():
            self._doc.layers.add(name, color=colour)
        self._doc.layers.get("WALLS_INFERRED").dxf.linetype = "INFERRED"
        # Ceilings would lie over the floors.
        self._doc.layers.get("CEILINGS").off()
        letter_m = SIZE * CAP_HEIGHT * self._unit_m
        self._doc.dimstyles.add(
            _STYLE,
            dxfattribs={
                "dimtxt": letter_m,
                "dimasz": 7.0 * self._unit_m,
                "dimexe": 2.0 * self._unit_m,
                "dimexo": (BAND + 3.0) * self._unit_m,
                "dimgap": 0.4 * letter_m,
                "dimtad": 1,
                "dimtxsty": _STYLE,
                "dimdec": 4,
                "dimzin": 0,
                "dimlunit": 2,
                "dimdsep": ord("."),
                "dimscale": 1.0,
                "dimlfac": 1.0,
            },
        )
        self._space = self._doc.modelspace()

    def content(self) -> bytes:
        """The file."""
        text = io.StringIO()
        self._doc.write(text)
        return text.getvalue().encode("utf-8", "surrogateescape")

    def outline(self, result: FitResult) -> None:
        """Floors and ceilings as closed polylines, and over them walls and sides of levels as lines."""
        for face in result.faces:
            if face.kind in ("floor", "ceiling"):
                layer = "FLOORS" if face.kind == "floor" else "CEILINGS"
                for k, ring in enumerate(face.rings_m):
                    facts = {**face_facts(face), "ring": k}
                    self._polyline(result.frame.to_manhattan(ring)[:, :2], layer, facts)
        for face in result.faces:
            wall = self._layout.outline.line(face.id)
            if wall is not None:
                start, end = self._to_model(wall.points()).tolist()
                layer = "WALLS_INFERRED" if wall.inferred else "STEPS" if face.kind == "step" else "WALLS"
                line = self._space.add_line(start, end, dxfattribs={"layer": layer})
                _attach(line, "face", face_facts(face))

    def _polyline(self, points: Float[np.ndarray, "n 2"], layer: str, facts: dict) -> None:
        line = self._space.add_lwpolyline((points + 0.0).tolist(), close=True, dxfattribs={"layer": layer})
        _attach(line, "face", facts)

    def dimension(self, result: FitResult, placement: Placement) -> None:
        """One linear dimension; its number is measured from its points, the rest of its text is added."""
        span = placement.span
        number, _, spread = span.text.partition(" ")
        text = f"{_plain(span.ids)}  <> {spread}" if span.text else _plain(span.ids)
        # In the direction of growing coordinates, or the arrows would point outward; the page's y is down.
        ends = span.ends if span.axis == 0 else span.ends[::-1]
        points = [self._foot(span, end, placement.at) for end in ends]
        base = self._point(span, span.low, placement.at)
        layer = "DIMENSIONS_INFERRED" if span.inferred else "DIMENSIONS"
        # By number: programs differ in what BYLAYER means within the block of a dimension.
        colours = dict.fromkeys(("dimclrd", "dimclre", "dimclrt"), _LAYERS[layer])
        made = self._space.add_linear_dim(
            base=base,
            p1=points[0],
            p2=points[1],
            angle=0 if span.axis == 0 else 90,
            text=text,
            # Along its line, unless the layout found it a place beside a short one.
            text_rotation=0.0 if span.axis == 1 and not placement.upright else None,
            dimstyle=_STYLE,
            override={"dimdec": len(number.partition(".")[2]), **colours},
            dxfattribs={"layer": layer},
        )
        faces = {end.id for end in ends}
        for dimension in result.dimensions:
            if set(dimension.faces) == faces:
                _attach(made.dimension, "dimension", dimension_facts(dimension))
        made.set_location(self._to_model(np.array([placement.text_at]))[0].tolist())
        made.render()

    def _foot(self, span: Span, end: WallLine, at: float) -> tuple[float, float]:
        """Where the wall ends that the extension line starts from."""
        if extension_start(end, at) is None:
            return self._point(span, end.at, at)
        return self._point(span, end.at, end.low if at < end.low else end.high)

    def _point(self, span: Span, along: float, across: float) -> tuple[float, float]:
        pair = (along, across) if span.axis == 0 else (across, along)
        x, y = self._to_model(np.array([pair]))[0].tolist()
        return x, y

    def _to_model(self, points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """From the page to Manhattan metres."""
        return points * np.array([self._unit_m, -self._unit_m]) + 0.0

    def texts(self) -> None:
        """Names of rooms and walls."""
        middle = self._ezdxf.enums.TextEntityAlignment.MIDDLE_CENTER
        for label in self._layout.names:
            if isinstance(label, Label):
                text = self._space.add_text(
                    _plain(label.text),
                    height=label.size * CAP_HEIGHT * self._unit_m,
                    rotation=90.0 if label.upright else 0.0,
                    dxfattribs={"layer": "NAMES", "style": _STYLE},
                )
                text.set_placement(self._to_model(np.array([label.at]))[0].tolist(), align=middle)

    def notes(self, result: FitResult) -> None:
        """What the drawing is, below it, and the same for programs in the custom properties."""
        variables = self._doc.header.custom_vars
        for key, value in model_facts(result).items():
            variables.append(f"indoorfit.{key}", value if isinstance(value, str) else one_line({key: value}))
        variables.append("indoorfit.scale", f"1:{self._layout.denominator}")
        origin = ", ".join(f"{value:.4f}" for value in result.frame.origin_scan_m.tolist())
        lines = [
            f"indoorfit, {result.method} fit; metres; intervals at {100.0 * result.level:g} %",
            f"Letters for 1:{self._layout.denominator}. Origin of this drawing in the scan: {origin}",
        ]
        for room in result.rooms:
            facts = room_facts(room)
            lines.append(f"{room.id}: floor {facts['floor_area_value_m2']:.3f} m\u00b2")
        lines += [f"Without its value in the drawing: {span.label}" for span in self._layout.cramped]
        left, _, _, bottom = self._layout.outline.room_box()
        marks = [box for placement in self._layout.placements for box in _boxes(placement)]
        bottom = max([bottom, *(box[3] for box in marks)]) + 24.0
        corner = self._to_model(np.array([[left, bottom]]))[0].tolist()
        note = self._space.add_mtext("\\P".join(map(_plain, lines)), dxfattribs={"layer": "NOTES"})
        note.dxf.style = _STYLE
        note.dxf.char_height = 0.9 * SIZE * CAP_HEIGHT * self._unit_m
        note.set_location(corner)


def _boxes(placement: Placement) -> tuple[Box, ...]:
    return (*placement.marks.texts, *placement.marks.lines)


def _attach(entity: Any, kind: str, facts: dict) -> None:
    """Put facts on an entity; several of a kind one after the other."""
    tags = list(entity.get_xdata(APP_ID)) if entity.has_xdata(APP_ID) else []
    tags = [(code, value) for code, value in tags if code != 1001]
    tags.append((1000, kind))
    for key, value in facts.items():
        text = str(value).encode("utf-8", "replace")[:_STRING_BYTES].decode("utf-8", "ignore")
        tags.append((1000, key))
        tags.append((1040, float(value)) if isinstance(value, int | float) else (1000, _printable(text)))
    entity.set_xdata(APP_ID, tags)


def _printable(text: str) -> str:
    """Without line ends, which end a value in DXF."""
    return "".join(c if c.isprintable() else " " for c in text)


def _plain(text: str) -> str:
    """A text without the marks of formatting and fields: ``\\ { } ^ %% <>``."""
    replaced = text.translate(str.maketrans({"\\": "/", "{": "(", "}": ")", "^": "_", "<": "(", ">": ")"}))
    return _printable(replaced.replace("%%", "% %"))
