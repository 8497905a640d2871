"""Images stay on their faces, the right way round, in the formats that carry them beside the file."""

import io
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import collada
import numpy as np
import pytest
from collada.schema import ColladaValidator
from lxml import etree
from PIL import Image
from rooms import FLAT, make_result

from indoorfit.model import FitResult, TextureImage, TexturePlacement, TextureSet
from indoorfit.pipeline import FORMATS

SPACE = "{http://www.collada.org/2005/11/COLLADASchema}"


def textured(result: FitResult) -> FitResult:
    """One image per face, over its whole extent, upright as seen from inside; the last face has none."""
    images, placements = [], {}
    content = io.BytesIO()
    Image.new("RGB", (4, 4), (200, 10, 10)).save(content, "PNG")
    for face in result.faces[:-1]:
        corners = np.concatenate(face.rings_m)
        up = result.frame.directions_to_scan(np.array([0.0, 0.0, 1.0]))
        if face.kind != "wall":
            up = result.frame.directions_to_scan(np.array([0.0, 1.0, 0.0]))
        right = np.cross(up, face.normal)
        local = (corners - corners[0]) @ np.stack([right, up], axis=1)
        low, size = local.min(axis=0), np.ptp(local, axis=0)
        origin = corners[0] + low[0] * right + low[1] * up
        images.append(TextureImage(f"{face.id}.png", "png", 4, 4, content.getvalue()))
        u_per_m, v_per_m = right / size[0], up / size[1]
        placements[face.id] = TexturePlacement(
            face.id, f"{face.id}.png", origin, np.zeros(2), u_per_m, v_per_m, 0.01, "points", 1.0, 0.0
        )
    return replace(result, textures=TextureSet(tuple(images), placements))


def read_x3d(path: Path) -> dict[str, tuple[str | None, np.ndarray | None]]:
    found = {}
    for shape in ET.parse(path).getroot().iter("Shape"):
        image, points = shape.find("Appearance/ImageTexture"), shape.find("IndexedFaceSet/TextureCoordinate")
        name = shape.find("MetadataSet/MetadataString[@name='id']").get("value").strip('"')
        corners = np.array(shape.find("IndexedFaceSet/Coordinate").get("point").split(), float).reshape(-1, 3)
        uv = None if points is None else np.array(points.get("point").split(), float).reshape(-1, 2)
        found[name] = (None if image is None else image.get("url").strip('"'), corners, uv)
    return found


def read_dae(path: Path) -> dict[str, tuple[str | None, np.ndarray | None]]:
    assert ColladaValidator().validate(etree.parse(path))
    document = collada.Collada(str(path))
    found = {}
    for node in (
        node for room in document.scene.nodes for node in room.children if hasattr(node, "children")
    ):
        (instance,) = (child for child in node.children if isinstance(child, collada.scene.GeometryNode))
        diffuse = instance.materials[0].target.effect.diffuse
        image = diffuse.sampler.surface.image.path if hasattr(diffuse, "sampler") else None
        (primitive,) = instance.geometry.primitives
        uv = primitive.texcoordset[0] if primitive.texcoordset else None
        if uv is not None:
            assert (primitive.texcoord_indexset[0] == primitive.vertex_index).all()
            assert instance.materials[0].inputs == [("UV", "TEXCOORD", "0")]
        found[instance.geometry.name] = (image, np.asarray(primitive.vertex, float), uv)
    return found


READERS: dict[str, Callable] = {"x3d": read_x3d, "dae": read_dae}


@pytest.mark.parametrize("name", READERS)
def test_images_lie_on_their_faces_and_are_not_mirrored(name, tmp_path):
    result = textured(make_result(*FLAT))
    path = tmp_path / FORMATS[name].file_name
    FORMATS[name].write(path, result, None)
    found = READERS[name](path)
    assert set(found) == {face.id for face in result.faces}
    for face in result.faces[:-1]:
        image, corners, uv = found[face.id]
        assert image == f"textures/{face.id}.png"
        assert (path.parent / image).is_file()
        # The affine map from corners to (u, v), by least squares over the corners.
        local = corners - corners.mean(axis=0)
        gradients = np.linalg.lstsq(local, uv - uv.mean(axis=0), rcond=1e-6)[0].T
        normal = face.normal if name == "x3d" else result.frame.R_manhattan_scan @ face.normal
        up = np.array([0.0, 0.0, 1.0]) if face.kind == "wall" else np.array([0.0, 1.0, 0.0])
        up = result.frame.directions_to_scan(up) if name == "x3d" else up
        assert np.cross(gradients[0], gradients[1]) @ normal > 0.0
        assert gradients[1] @ up == pytest.approx(np.linalg.norm(gradients[1]), rel=1e-4)
        # 32 bits in pycollada.
        np.testing.assert_allclose([uv.min(axis=0), uv.max(axis=0)], [[0, 0], [1, 1]], rtol=0, atol=1e-6)
    assert found[result.faces[-1].id][0] is None


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_can_be_written_of_a_textured_model(name, tmp_path):
    result = textured(make_result(*FLAT))
    FORMATS[name].write(tmp_path / FORMATS[name].file_name, result, None)
    assert (tmp_path / "textures").exists() == (name in ("vrml", "x3d", "obj", "dae"))
