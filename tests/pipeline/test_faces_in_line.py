"""Two faces of one plane are seen, or not, each for itself."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.config import RunConfig
from indoorfit.model import FitResult
from indoorfit.pipeline import fit_scan, truth_result
from indoorfit.simulate.virtual import VirtualScan
from indoorfit.texture import TextureConfig
from synthetic import virtual


@pytest.fixture(scope="module")
def half_seen() -> VirtualScan:
    """A U whose arms end in line; the end of one has no point, but floor and ceiling go up to it."""
    whole = virtual("U", 4, n_points=60_000)
    (notch,) = (cube for cube in whole.shape.cubes if cube.role == "notch")
    beside_m = whole.shape.bounds_m()[notch.id][1, 0]
    ends = whole.shape.rooms[0].sides["+y"]
    points_m = whole.frame.to_manhattan(whole.scan.points_m)
    gone = (whole.point_plane == ends) & (points_m[:, 0] > beside_m - 0.1)
    scan = replace(whole.scan, points_m=whole.scan.points_m[~gone])
    return replace(whole, scan=scan, point_plane=whole.point_plane[~gone])


@pytest.fixture(scope="module", params=["fit", "truth"])
def result(request, half_seen) -> FitResult:
    if request.param == "fit":
        return fit_scan(half_seen.scan, RunConfig(texture=TextureConfig(enabled=False)))
    return truth_result(half_seen.shape, half_seen.frame, {}, 0, half_seen)


def ends(result: FitResult):
    """The two faces of the plane that both arms end at, the unseen one first."""
    planes = [face.plane for face in result.faces if face.kind == "wall"]
    (shared,) = {plane for plane in planes if planes.count(plane) == 2}
    return sorted((face for face in result.faces if face.plane == shared), key=lambda face: face.n_points)


def test_a_face_without_points_is_inferred_beside_a_seen_one_of_its_plane(result):
    unseen, seen = ends(result)
    assert (unseen.status, unseen.coverage) == ("inferred", pytest.approx(0.0, abs=0.02))
    assert seen.status == "observed"
    assert seen.coverage > 0.8
    # Nothing of one is counted for the other.
    assert seen.n_points > 1000 > 10 > unseen.n_points


def test_lengths_that_end_at_it_are_inferred_and_those_at_the_seen_one_are_not(result):
    unseen, seen = ends(result)
    walls = [dimension for dimension in result.dimensions if dimension.kind == "wall"]
    assert {d.status for d in walls if unseen.id in d.faces} == {"inferred"}
    assert {d.status for d in walls if seen.id in d.faces} == {"observed"}
    # The extent was seen at the other arm.
    assert {d.status for d in result.dimensions if d.kind == "overall"} == {"observed"}


def test_a_warning_names_it_and_what_it_is_taken_to_be_in_line_with(half_seen):
    found = fit_scan(half_seen.scan, RunConfig(texture=TextureConfig(enabled=False)))
    unseen, seen = ends(found)
    (note,) = (note for note in found.notes if note.code == "FACE_INFERRED")
    assert note.faces == (unseen.id,)
    assert f"{unseen.id} with {seen.id}" in note.message


def test_coverage_of_a_plane_is_that_of_its_faces(half_seen):
    truth = truth_result(half_seen.shape, half_seen.frame, {}, 0, half_seen)
    assert sum(face.n_points for face in truth.faces) == np.sum(half_seen.point_plane >= 0)
