"""Scenes survive the disk, and become the shapes and openings that they describe."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoorfit.errors import ConfigError
from indoorfit.geometry import exposures
from indoorfit.simulate import (
    Opening,
    RandomSceneSettings,
    RoomPlan,
    Scene,
    Step,
    build_scene,
    handheld_path,
    random_room,
    random_scene,
    read_scene,
    room_plans,
    scene_shape,
    write_scene,
)

BOX = RoomPlan((0.0, 5.0), (0.0, 4.0), ("#",), 0.0, 2.7)
FULL = RandomSceneSettings(
    n_walls=10,
    n_furniture=6,
    bookcase=True,
    glass_wall=True,
    floor_step=True,
    beam=True,
    oblique=True,
    uneven_m=0.01,
)


@pytest.mark.parametrize("suffix", ["toml", "json"])
@pytest.mark.parametrize("seed", range(5))
def test_scene_round_trip_is_exact(tmp_path, suffix, seed):
    scene = random_scene(np.random.default_rng(seed), FULL, f'seed "{seed}" \\ ü')
    write_scene(scene, tmp_path / f"scene.{suffix}")
    assert read_scene(tmp_path / f"scene.{suffix}") == scene


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("rooms = 3", "not a scene"),
        ("rooms = []\ncolour = 'red'", "colour"),
        ("rooms = [", "not valid TOML"),
    ],
    ids=["wrong-type", "unknown-key", "syntax"],
)
def test_bad_scene_files_are_refused_with_a_remedy(tmp_path, text, message):
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(ConfigError, match=message) as caught:
        read_scene(tmp_path / "scene.toml")
    assert "Fix:" in str(caught.value)


def test_missing_scene_file_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.toml"):
        read_scene(tmp_path / "none.toml")


@settings(deadline=None, max_examples=25)
@given(seed=st.integers(0, 1000), half=st.integers(2, 7))
def test_room_plans_give_back_the_shape(seed, half):
    shape = random_room(np.random.default_rng(seed), 2 * half)
    assert scene_shape(Scene(room_plans(shape))) == shape


def test_platform_and_beam_become_cubes_with_the_planes_that_show():
    platform = Step(0, "floor", (0.0, 0.0), (1.5, 4.0), 0.2)
    beam = Step(0, "ceiling", (0.0, 2.0), (5.0, 2.3), 0.35)
    shape = scene_shape(Scene((BOX,), steps=(platform, beam)))
    assert [cube.role for cube in shape.cubes] == ["room", "step", "beam"]
    # The platform shows its top and one riser, the beam its underside and two flanks.
    assert len(shape.planes) == 6 + 2 + 3
    by_class = {}
    for exposure in exposures(shape):
        face = shape.planes[exposure.plane].face_class
        by_class[face] = by_class.get(face, 0.0) + exposure.area_m2
    # 1e-12 m²: rounding. Platform and lowered ceiling are floor and ceiling as well.
    assert by_class["floor"] == pytest.approx(20.0, abs=1e-12)
    assert by_class["ceiling"] == pytest.approx(20.0, abs=1e-12)
    assert by_class["left"] == pytest.approx(by_class["right"], abs=1e-12)


def test_step_that_ends_in_a_notch_has_no_hidden_plane():
    ell = RoomPlan((0.0, 4.0, 5.0), (0.0, 2.5, 4.0), ("#.", "##"))
    step = Step(0, "ceiling", (2.0, 3.0), (4.0, 4.0), 0.4)
    shape = scene_shape(Scene((ell,), steps=(step,)))
    assert min(e.area_m2 for e in exposures(shape)) > 0.0
    assert shape.cubes[-1].open_sides == ("+x", "+y", "+z")


@pytest.mark.parametrize(
    "scene",
    [
        Scene(()),
        Scene((RoomPlan((0.0, 1.0), (0.0, 1.0), ("##",)),)),
        Scene((RoomPlan((0.0, 1.0), (0.0, 1.0), (".",)),)),
        Scene((RoomPlan((0.0, 1.0), (0.0, 1.0), ("#",), 2.7, 0.0),)),
        Scene((BOX,), steps=(Step(1, "floor", (0.0, 0.0), (1.0, 1.0), 0.2),)),
        Scene((BOX,), steps=(Step(0, "floor", (0.0, 0.0), (1.0, 1.0), 3.0),)),
        Scene((BOX,), openings=(Opening("door", "x", (2.5, 2.0), 0.9, 0.0, 2.0),)),
    ],
    ids=["no-room", "cells", "no-cell", "upside-down", "no-such-room", "too-high", "no-wall-there"],
)
def test_impossible_scenes_are_refused_with_a_remedy(scene):
    with pytest.raises(ConfigError, match="Fix:"):
        build_scene(scene)


def test_window_takes_its_area_from_the_wall_and_adds_jambs():
    window = Opening("window", "x", (0.0, 2.0), 1.2, 0.9, 2.1, view_m=None)
    built = build_scene(Scene((BOX,), openings=(window,)))
    areas_m2 = built.quads.size_m.prod(axis=1)
    wall = next(k for k, p in enumerate(built.shape.planes) if p.face_class == "left")
    assert areas_m2[built.quads.plane == wall].sum() == pytest.approx(4.0 * 2.7 - 1.44, abs=1e-12)
    assert areas_m2[built.quads.plane == -1].sum() == pytest.approx(0.2 * 4.8, abs=1e-12)


def test_door_between_rooms_pierces_both_sides_of_the_partition():
    other = RoomPlan((5.2, 8.0), (0.0, 4.0), ("#",), 0.0, 2.7)
    door = Opening("door", "x", (5.1, 2.0), 0.9, 0.0, 2.0)
    built = build_scene(Scene((BOX, other), openings=(door,)))
    areas_m2 = built.quads.size_m.prod(axis=1)
    for k, plane in enumerate(built.shape.planes):
        if plane.offset_m in (5.0, 5.2):
            assert areas_m2[built.quads.plane == k].sum() == pytest.approx(4.0 * 2.7 - 1.8, abs=1e-12)
    jambs_m = built.quads.corners_m()[built.quads.plane == -1]
    # The jambs span exactly the partition.
    assert (jambs_m[..., 0].min(), jambs_m[..., 0].max()) == (5.0, 5.2)


def test_scene_of_the_documentation_can_be_scanned(tmp_path):
    page = (Path(__file__).resolve().parents[2] / "docs" / "simulate.md").read_text(encoding="utf-8")
    (tmp_path / "study.toml").write_text(page.split("```text\n")[1].split("```")[0], encoding="utf-8")
    scene = read_scene(tmp_path / "study.toml")
    built = build_scene(scene)
    # Six walls, floor and ceiling, and the beam's two sides and its bottom.
    assert len(built.shape.planes) == 11
    assert len(handheld_path(scene, 3, np.random.default_rng(0))) == 3
