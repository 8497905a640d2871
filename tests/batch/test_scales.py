"""The noise scales that are learnt are those that the errors were made with."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from indoorfit.batch import learn_scales, scales_toml
from indoorfit.batch.calibration import JudgedLength
from indoorfit.config import config_from_dict

Z95 = 1.959963984540054


def lengths(n_rooms, rng, factor=1.0, scale=0.0, definition_m=0.0, per_room=5, data_share=1.0):
    """Errors of lengths of 0.3 to 12 m; intervals know of the residuals' part alone."""
    found = []
    for k in range(n_rooms):
        for _ in range(per_room):
            data_m, value_m = rng.uniform(0.0005, 0.002), rng.uniform(0.3, 12.0)
            std_m = np.sqrt((factor * data_m) ** 2 + (scale * value_m) ** 2 + definition_m**2)
            error_m = float(std_m * rng.standard_normal())
            half_m = Z95 * data_m / data_share
            found.append(JudgedLength(f"room-{k}", error_m, half_m, 0.95, 0.0, value_m, data_share))
    return found


@pytest.mark.parametrize(
    ("factor", "scale", "definition_m"),
    [(1.0, 0.004, 0.0), (2.0, 0.0, 0.0), (1.0, 0.0, 0.006), (1.0, 0.003, 0.005)],
    ids=["scale", "factor", "definition", "scale and definition"],
)
def test_every_part_is_found_within_its_uncertainty(factor, scale, definition_m):
    found = learn_scales(lengths(25, np.random.default_rng(1), factor, scale, definition_m))
    assert found.scale_std.low <= scale <= found.scale_std.high
    assert found.definition_std_m.low <= definition_m <= found.definition_std_m.high
    assert found.factor.low <= factor <= found.factor.high
    # 125 errors: 6 % of a single scale each way, four of them 25 %.
    if scale and not definition_m:
        assert found.scale_std.value == pytest.approx(scale, rel=0.25)
    # 125 lengths: four standard errors of a share of 0.95 are 8 %.
    assert found.held == pytest.approx(0.95, abs=0.08)


def test_scales_do_better_than_one_factor_where_errors_grow_with_the_length():
    found = learn_scales(lengths(25, np.random.default_rng(2), scale=0.004))
    assert found.score_m < found.score_factor_m < found.score_before_m


def test_what_the_batch_had_added_itself_is_learnt_anew():
    rng = np.random.default_rng(3)
    sample = lengths(15, rng, scale=0.004)
    # The same errors with intervals that somebody had made twice as wide by type_b.
    wide = [replace(length, half_m=2.0 * length.half_m, data_share=0.5) for length in sample]
    # Two optimisations to a relative 1e-5 of the likelihood, flat at its top.
    assert learn_scales(wide).scale_std.value == pytest.approx(learn_scales(sample).scale_std.value, rel=0.01)


def test_the_preset_makes_the_intervals_that_were_learnt():
    found = learn_scales(lengths(15, np.random.default_rng(4), 2.0, 0.004))
    settings = {"type_b": {"sensor": "laser"}, "belief": {"inflation": 3.0}}
    config = config_from_dict(tomllib.loads(scales_toml(found, settings, 0.95)))
    assert config.type_b.sensor == "laser"
    assert config.type_b.scale_std is not None
    assert config.type_b.definition_std_m is not None
    inflation = config.belief.inflation
    # The factor lies on everything, so the others are written divided by it; four digits are kept. The
    # residuals' part had been made three times as wide already.
    assert inflation == pytest.approx(3.0 * found.factor.value, rel=1e-3)
    assert inflation * config.type_b.scale_std == pytest.approx(found.scale_std.value, rel=2e-3)
    assert inflation * config.type_b.definition_std_m == pytest.approx(found.definition_std_m.value, rel=2e-3)
    assert config.type_b.scale_dof == 14
