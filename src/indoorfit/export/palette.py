"""One calm colour per kind of face, the same in every format and picture."""

from indoorfit.model import Face, FaceClass

_COLOURS: dict[FaceClass, tuple[int, int, int]] = {
    "floor": (203, 184, 158),
    "ceiling": (244, 243, 239),
    # The four walls differ a little, so that a corner shows even in a viewer without light.
    "front": (226, 223, 213),
    "back": (218, 214, 203),
    "left": (205, 215, 217),
    "right": (214, 222, 223),
}
_INFERRED = (232, 199, 158)


def face_colour(face: Face) -> tuple[int, int, int]:
    """Red, green, blue of a face, sRGB, 0 to 255. Faces without points stand out in amber."""
    return _INFERRED if face.status == "inferred" else _COLOURS[face.face_class]


def material_name(face: Face) -> str:
    """Name of the face's colour, the same for all faces that share it."""
    return "inferred" if face.status == "inferred" else face.face_class


def linear_rgb(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    """From sRGB to linear light, 0 to 1, as glTF wants it (IEC 61966-2-1)."""
    r, g, b = (_linear(channel / 255.0) for channel in colour)
    return r, g, b


def _linear(value: float) -> float:
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
