"""What explanation says of a candidate is what the energy says, and overrides are honoured or told."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.config import RunConfig, config_from_dict, load_overrides
from indoorfit.errors import ConfigError
from indoorfit.model import IgnoredBox, OverrideConfig, WallLine
from indoorfit.pipeline import explain_scan, fit_scan
from synthetic import virtual


@pytest.fixture(scope="module")
def scan():
    return virtual("L", 1, n_points=20_000, yaw_deg=15).scan


@pytest.fixture(scope="module")
def explained(scan):
    return explain_scan(scan)


def explained_with(scan, **overrides):
    return explain_scan(scan, RunConfig(overrides=OverrideConfig(**overrides)))


def told(notes):
    return " ".join(note.message for note in notes if note.code == "OVERRIDDEN")


def test_accepted_candidates_are_the_walls_of_the_fit(scan, explained):
    shape = fit_scan(scan).shape
    for axis in (0, 1):
        walls_m = sorted({round(p.offset_m, 6) for p in shape.planes if p.axis == axis})
        accepted = [
            c.position_m
            for c in explained.explanation.candidates
            if c.axis == axis and c.verdict == "accepted"
        ]
        assert len(accepted) == len(walls_m)
        # A candidate is a median of surfels of 5 mm noise, the fit a mean of all points.
        np.testing.assert_allclose(accepted, walls_m, atol=0.01)


def test_no_other_plan_is_better(explained):
    differences = [c.difference_nats for c in explained.explanation.candidates]
    assert all(d is not None for d in differences)
    # The labelling is the minimum, what differs from it costs; 1e-6 of the energy is the solver's rounding.
    assert min(differences) >= -1e-6 * abs(explained.explanation.energy_nats)


def test_a_forbidden_wall_costs_what_its_explanation_says(scan, explained):
    wall = max(
        (c for c in explained.explanation.candidates if c.axis == 0 and c.verdict == "accepted"),
        key=lambda c: -c.difference_nats,
    )
    line = WallLine(axis="x", position_m=wall.position_m)
    without = explained_with(scan, forbid_wall=(line,)).explanation
    change = without.energy_nats - explained.explanation.energy_nats
    # Forbidden borders are out of both minimisations; the solver's rounding is 1e-7 of the energy.
    assert change == pytest.approx(wall.difference_nats, rel=1e-5)
    named = next(c for c in without.candidates if c.id == wall.id)
    assert named.verdict == "forbidden"
    assert "no wall runs there" in told(without.notes)


def test_a_forced_wall_parts_the_room_and_is_recorded(scan, explained):
    x_m, y_m = explained.explanation.grid
    at = 0.5 * (x_m[0] + x_m[1])
    ends = explained.frame.to_scan(np.array([[at, y_m[0], 0.0], [at, y_m[-1], 0.0]])).tolist()
    config = RunConfig(overrides=OverrideConfig(force_wall=(WallLine(tuple(ends[0]), tuple(ends[1])),)))
    found = explain_scan(scan, config).explanation
    assert found.room.max() == explained.explanation.room.max() + 1
    forced = [c for c in found.candidates if c.forced]
    assert [c.verdict for c in forced] == ["accepted"]
    # The two points are exact; rounding of the turn to the scan and back.
    assert forced[0].position_m == pytest.approx(at, abs=1e-9)
    result = fit_scan(scan, config)
    assert len(result.rooms) == 2
    assert result.provenance["config"]["overrides"]["force_wall"]
    assert "bounds rooms" in told(result.notes)


def test_an_ignored_box_is_as_if_it_had_not_been_scanned(scan):
    low = scan.points_m.min(axis=0) - 1.0
    high = [*(low[:2] + 2.5), 10.0]
    box = IgnoredBox(tuple(low.tolist()), tuple(map(float, high)))
    kept = ~np.all((scan.points_m >= low) & (scan.points_m <= high), axis=1)
    assert not np.all(kept)
    alone = replace(
        scan, points_m=scan.points_m[kept], colours=None if scan.colours is None else scan.colours[kept]
    )
    ignored, cut = explained_with(scan, ignore_box=(box,)), explain_scan(alone)
    np.testing.assert_array_equal(ignored.explanation.log_odds, cut.explanation.log_odds)
    assert f"{np.sum(~kept)} points" in told(ignored.explanation.notes)


def test_yaw_turns_the_frame_from_the_scan_x(scan):
    # The room's own direction is 15 degrees; a quarter more is the same room with the axes exchanged.
    frame = explained_with(scan, yaw_deg=105.0).frame
    x_axis = frame.R_manhattan_scan[0]
    # The scan is not tilted but by what the up direction is off: well below a degree.
    assert np.rad2deg(np.arctan2(x_axis[1], x_axis[0])) == pytest.approx(105.0, abs=0.1)


def test_up_said_wins(scan):
    frame = explained_with(scan, up="-z").frame
    assert frame.R_manhattan_scan[2] @ [0.0, 0.0, -1.0] > 0.99


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"force_wal": []}, "force_wal"),
        ({"force_wall": [{"axis": "x"}]}, "needed either"),
        ({"ignore_box": [{"low_m": [0, 0, 0], "high_m": [1, 1, 0]}]}, "is empty"),
        ({"ignore_box": [{"low_m": [0, 0], "high_m": [1, 1, 1]}]}, "low_m"),
        ({"yaw_deg": 1000.0}, "yaw_deg"),
        ({"up": "w"}, "up"),
    ],
    ids=["unknown", "half-a-wall", "empty-box", "short-point", "yaw", "up"],
)
def test_impossible_settings_are_refused(settings, words):
    with pytest.raises(ConfigError, match=words):
        config_from_dict({"overrides": settings})


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"force_wall": (WallLine(axis="x", position_m=40.0),)}, "outside of the room"),
        ({"forbid_wall": (WallLine(axis="x", position_m=40.0),)}, "no candidate within"),
        ({"force_wall": (WallLine((0.0, 0.0, 0.0), (1.0, 1.0, 0.0)),)}, "degrees off"),
        ({"force_wall": (WallLine((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),)}, "apart in the plan"),
        ({"ignore_box": (IgnoredBox((50.0, 0.0, 0.0), (51.0, 1.0, 1.0)),)}, "no point of"),
        ({"ignore_box": (IgnoredBox((-99.0, -99.0, -99.0), (99.0, 99.0, 99.0)),)}, "every point"),
    ],
    ids=["outside", "no-candidate", "oblique", "short", "nothing-in-box", "everything-in-box"],
)
def test_overrides_that_cannot_be_meant_are_refused(scan, overrides, words):
    with pytest.raises(ConfigError, match=words):
        explained_with(scan, **overrides)


def test_walls_need_the_joint_method(scan):
    said = OverrideConfig(force_wall=(WallLine(axis="x", position_m=0.0),))
    with pytest.raises(ConfigError, match="joint method"):
        fit_scan(scan, RunConfig(method="greedy", overrides=said))


def test_a_file_of_overrides_holds_nothing_else(tmp_path):
    path = tmp_path / "said.toml"
    path.write_text('[overrides]\nup = "z"\n[[overrides.forbid_wall]]\naxis = "y"\nposition_m = -1.5\n')
    assert load_overrides(path).forbid_wall == (WallLine(axis="y", position_m=-1.5),)
    path.write_text("seed = 3\n")
    with pytest.raises(ConfigError, match="nothing else"):
        load_overrides(path)
