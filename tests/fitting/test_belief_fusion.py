"""What is said and kept where the two noise models are put together."""

import numpy as np

from indoorfit.fitting.belief import _completed, _fused
from indoorfit.fitting.uncertainty import FusionConfig, Predictive
from indoorfit.geometry import shape_from_plan
from indoorfit.model import Frame


def test_a_plane_that_no_frame_saw_is_as_sure_as_the_cloud_without_frames_makes_it():
    """What both noise models add, such as the bias through the edges, counts once."""
    both, of_walls = np.full((1, 2, 2), 4e-8), np.diag([1e-6, 9e-6])[None]
    means, contrasts = np.zeros((1, 2)), np.array([[-1.0, 1.0]])
    wall = Predictive(np.ones(1), means, of_walls + both, np.ones(2, bool), contrasts)
    of_frames = np.diag([1e-8, 0.0])[None]
    pose = Predictive(np.ones(1), means, of_frames + both, np.array([True, False]), contrasts)
    found = _completed(pose, wall)
    # Rounding.
    np.testing.assert_allclose(np.diag(found.covariances[0]), [5e-8, 9.04e-6], rtol=1e-12)
    assert found.seen.all()


def test_the_warning_of_a_displaced_block_tells_how_far_it_is_and_not_what_is_merely_unsure():
    shape = shape_from_plan([0.0, 5.0], [0.0, 4.0], [np.ones((1, 1), bool)], [(0.0, 2.5)])
    contrasts = np.zeros((2, 9))
    contrasts[0, [5, 6]] = contrasts[1, [7, 8]] = -1.0, 1.0
    variances_m2 = np.diag(np.square([*[1e-5] * 3, 1e-3, 1e-3, 1e-3, 1e-3, 0.2, 0.2]))[None]
    theta = np.concatenate([np.zeros(3), shape.offsets_m])
    # The one length moves by 20 mm, many times its uncertainty; the other by 90 mm, a fraction of it.
    moved = theta + np.array([0, 0, 0, 0, 0, 0, 0.02, 0, 0.09])
    sentence = {"sentence": ""}
    wall, pose = (
        Predictive(np.ones(1), place[None], variances_m2, np.ones(9, bool), contrasts, sentence)
        for place in (theta, moved)
    )
    found = _fused(wall, pose, shape, Frame(np.eye(3), np.zeros(3)), FusionConfig())
    (note,) = found.notes
    assert note.code == "REGISTRATION_INCONSISTENT"
    assert "1 of 2 distances" in note.message
    assert "by up to 20 mm" in note.message
