"""Textures from point colours: the thesis' three neighbours, and nothing that is not on the wall."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import BOX, PILLAR, make_result
from scipy.spatial import cKDTree

from indoorfit.errors import InputError
from indoorfit.model import Frame, Pictures, Scan
from indoorfit.pipeline import truth_result
from indoorfit.simulate import Box, SamplingSettings, room_shape, sample_surface, scan_frame
from indoorfit.texture import TextureConfig, pack, paint, texture_from_points
from indoorfit.texture.canvas import canvas_of
from indoorfit.texture.fill import diffuse

COARSE = TextureConfig(pixel_m=0.05)


def on_faces(result, n_per_m2, rng, colour):
    """Points spread evenly over the faces; `colour` takes Manhattan positions and the face."""
    points, colours = [], []
    for face in result.faces:
        canvas = canvas_of(face, result.frame, 0.02, 8192)
        at = canvas.positions_m(canvas.mask())
        at = at[rng.random(len(at)) < n_per_m2 * 0.02**2]
        points.append(at)
        colours.append(colour(result.frame.to_manhattan(at), face))
    return Scan(np.concatenate(points), np.concatenate(colours).round().astype(np.uint8))


@pytest.fixture(scope="module")
def box():
    result = make_result(BOX)

    def colour(points_m, face):
        return np.clip(128 + points_m @ np.array([[20.0, 5, 0], [0, 25, 8], [9, 0, 30]]), 0, 255)

    return result, on_faces(result, 2000, np.random.default_rng(0), colour)


def test_a_pixel_is_the_mean_of_its_three_nearest_points(box):
    result, scan = box
    texture = next(t for t in texture_from_points(result, scan, COARSE) if t.face == "wall-1")
    face = result.face("wall-1")
    # All points of the other faces are further from this plane than 1 mm or off its polygon's inside.
    near = np.abs((scan.points_m - face.rings_m[0][0]) @ face.normal) < 1e-3
    tree = cKDTree(scan.points_m[near])
    rows, columns = texture.rgba.shape[:2]
    for row, column in [(3, 4), (20, 30), (rows - 4, columns - 5)]:
        place = texture.origin_m + texture.pixel_m * (
            (column + 0.5) * texture.right + (row + 0.5) * texture.down
        )
        mean = scan.colours[near][tree.query(place, 3)[1]].mean(axis=0)
        # Rounding to bytes.
        np.testing.assert_allclose(texture.rgba[row, column, :3], mean, rtol=0.0, atol=0.51)


def test_every_face_is_seen_in_full_where_points_are_everywhere(box):
    result, scan = box
    textures = texture_from_points(result, scan, COARSE)
    assert [t.face for t in textures] == [face.id for face in result.faces]
    # One place in 300 000 is further than two spacings from all points (Poisson); here there are 40 000.
    assert min(t.seen for t in textures) > 0.999
    assert all(t.filled == 0.0 for t in textures)


def test_things_before_the_wall_stay_off_it(box):
    result, scan = box
    face = result.face("wall-1")
    # A red cupboard whose back is three centimetres from the wall, six standard deviations of 5 mm.
    canvas = canvas_of(face, result.frame, 0.01, 8192)
    back = canvas.positions_m(canvas.mask())[::7] + 0.03 * face.normal
    red = np.tile(np.array([[255, 0, 0]], np.uint8), (len(back), 1))
    both = replace(
        scan, points_m=np.concatenate([scan.points_m, back]), colours=np.concatenate([scan.colours, red])
    )
    first, second = (
        next(t for t in texture_from_points(result, s, COARSE) if t.face == "wall-1") for s in (scan, both)
    )
    np.testing.assert_array_equal(first.rgba, second.rgba)


def test_points_in_a_corner_go_to_the_wall_that_they_lie_on(box):
    result, _ = box
    colours = {face.id: np.random.default_rng(k).integers(30, 226, 3) for k, face in enumerate(result.faces)}
    scan = on_faces(
        result, 2000, np.random.default_rng(1), lambda p, face: np.tile(colours[face.id], (len(p), 1))
    )
    for texture in texture_from_points(result, scan, COARSE):
        seen = texture.rgba[texture.rgba[..., 3] > 0][:, :3]
        np.testing.assert_array_equal(seen, np.tile(colours[texture.face], (len(seen), 1)))


def test_a_hole_in_a_face_is_no_part_of_it():
    result = make_result(PILLAR)
    scan = on_faces(result, 3000, np.random.default_rng(0), lambda p, face: np.full((len(p), 3), 90.0))
    floor = next(t for t in texture_from_points(result, scan, COARSE) if t.face == "floor-1")
    # The pillar's 40 x 40 cm of 6 x 4.2 m.
    assert (floor.rgba[..., 3] == 0).mean() == pytest.approx(0.16 / 25.2, rel=0.02)
    assert floor.seen == 1.0


def without_a_window(result, scan, low=-0.5, high=0.5):
    face = result.face("wall-1")
    local = result.frame.to_manhattan(scan.points_m)
    near = np.abs((scan.points_m - face.rings_m[0][0]) @ face.normal) < 1e-3
    gone = near & (np.abs(local[:, 0]) < high) & (np.abs(local[:, 2]) < high)
    return replace(scan, points_m=scan.points_m[~gone], colours=scan.colours[~gone])


def test_gaps_are_transparent_or_filled_and_their_share_is_told(box):
    result, scan = box
    holed = without_a_window(result, scan)
    gap, filled = (
        next(t for t in texture_from_points(result, holed, config) if t.face == "wall-1")
        for config in (COARSE, replace(COARSE, gaps="fill"))
    )
    size_m2 = 4.0 * 2.7
    # The square of 1 m2, less two spacings (4.5 cm) of reach and a pixel on each side.
    assert 0.75 / size_m2 < 1.0 - gap.seen < 1.0 / size_m2
    assert (gap.rgba[..., 3] == 255).mean() == pytest.approx(gap.seen)
    assert (filled.rgba[..., 3] == 255).all()
    assert filled.filled == pytest.approx(1.0 - gap.seen)
    known = gap.rgba[..., 3] == 255
    np.testing.assert_array_equal(filled.rgba[known], gap.rgba[known])


def test_diffusion_continues_a_linear_colour_exactly():
    """A linear function solves Laplace's equation; here with a hole that touches no edge."""
    row, column = np.mgrid[:60, :80]
    colours = np.stack([row + 2.0 * column, 3.0 * row, 100.0 - column], axis=2)
    known = ~((np.abs(row - 30) < 15) & (np.abs(column - 40) < 22))
    mask = np.ones_like(known)
    filled = diffuse(np.where(known[..., None], colours, 0.0), known, mask)
    # What the sweeps leave of the start from the coarser raster, whose pixels are two of these wide.
    np.testing.assert_allclose(filled, colours, rtol=0.0, atol=1.5)
    np.testing.assert_array_equal(filled[known], colours[known])


def test_diffusion_stays_between_the_colours_around():
    rng = np.random.default_rng(0)
    known = rng.random((40, 50)) < 0.1
    mask = np.ones_like(known)
    mask[:, 20:25] = False
    colours = np.where(known[..., None], rng.random((40, 50, 3)) * [50.0, 100.0, 200.0], 0.0)
    filled = diffuse(colours, known & mask, mask)[mask]
    assert (filled >= colours[known & mask].min(axis=0) - 1e-9).all()
    assert (filled <= colours[known & mask].max(axis=0) + 1e-9).all()


def test_the_pose_of_the_scan_does_not_matter():
    shape = room_shape("L")
    settings = SamplingSettings(n_points=30_000, furniture=(Box((2.0, 0.1, 0.0), (2.8, 0.5, 1.2)),))
    virtual = sample_surface(shape, settings, np.random.default_rng(3))
    turned = scan_frame(0.7, 0.1, 0.3, (4e5, 5e6, 100.0))
    points_m = turned.to_scan(virtual.frame.to_manhattan(virtual.scan.points_m))
    moved = replace(virtual, frame=turned, scan=replace(virtual.scan, points_m=points_m))
    textures = [
        texture_from_points(truth_result(v.shape, v.frame, {}, 3, v), v.scan, COARSE)
        for v in (virtual, moved)
    ]
    for a, b in zip(*textures, strict=True):
        assert a.rgba.shape == b.rgba.shape
        # 5e6 m in float64 is known to 1e-9 m, which can turn a tie of neighbours round.
        assert (a.rgba != b.rgba).any(axis=2).mean() < 1e-3


def test_inferred_faces_and_scans_without_colours_get_no_texture(box):
    result, scan = box
    faces = tuple(replace(face, status="inferred") if face.id == "wall-2" else face for face in result.faces)
    assert "wall-2" not in {t.face for t in texture_from_points(replace(result, faces=faces), scan, COARSE)}
    bare = replace(scan, colours=None)
    assert paint(result, bare, Pictures(), COARSE) is None
    with pytest.raises(InputError, match="no colours"):
        texture_from_points(result, bare, COARSE)


def test_a_long_face_gets_larger_pixels_and_keeps_its_shape():
    frame = Frame(np.eye(3), np.zeros(3))
    result = make_result(BOX, frame=frame)
    canvas = canvas_of(result.face("floor-1"), frame, 0.01, 100)
    assert max(canvas.rows, canvas.columns) == 100
    assert canvas.columns / canvas.rows == pytest.approx(4.0 / 3.0, rel=0.02)


def test_equal_runs_give_equal_bytes(box):
    result, scan = box
    sets = [pack(texture_from_points(result, scan, COARSE), COARSE) for _ in range(2)]
    assert sets[0].images == sets[1].images


def test_sparse_points_look_the_same_at_any_pixel_size(box):
    """Blocks of pixels that share their neighbours hardly change what is seen."""
    result, scan = box
    few = replace(scan, points_m=scan.points_m[::40], colours=scan.colours[::40])
    fine, finer = (
        next(t for t in texture_from_points(result, few, TextureConfig(pixel_m=size)) if t.face == "wall-1")
        for size in (0.03, 0.01)
    )
    # The middle of every third pixel is that of a larger one.
    middle = finer.rgba[1::3, 1::3][: fine.rgba.shape[0], : fine.rgba.shape[1]]
    other = (middle != fine.rgba[: middle.shape[0], : middle.shape[1]]).any(axis=2)
    # Sets of three neighbours change every 6 cm or so (five Voronoi cells of order 3 a point, points 14 cm
    # apart), and the middles of blocks are at most 1.4 cm from those of their pixels: a quarter at most.
    assert other.mean() < 0.25
