"""What a reader of the dimensions must know about the faces behind them."""

from indoorfit.model import Note, Shape

from .named import Survey


def face_notes(shape: Shape, found: Survey) -> tuple[Note, ...]:
    """One note naming the faces that nobody saw."""
    inferred = [face.id for face in found.faces if shape.planes[face.polygon.plane].status == "inferred"]
    if not inferred:
        return ()
    names = ", ".join(inferred)
    return (
        Note(
            "FACE_INFERRED",
            f"Not observed: {names}. Each is placed where the surfaces around it end, and dimensions that "
            "rest on it are marked inferred; scan it, or measure it by hand, to be sure.",
            tuple(inferred),
        ),
    )
