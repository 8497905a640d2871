"""The factor on intervals is the one that the errors were made with, and conformal factors hold."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.batch import calibrate, preset_toml
from indoorfit.batch.calibration import JudgedLength, conformal_factor
from indoorfit.config import config_from_dict
from indoorfit.errors import InputError

Z95 = 1.959963984540054


def lengths(n_rooms, factor, rng, per_room=5, tape_m=0.0, share=0.5):
    """Errors whose standard deviation is `factor` times what the intervals say, partly common to a room."""
    found = []
    for k in range(n_rooms):
        common = rng.standard_normal()
        for _ in range(per_room):
            std_m = rng.uniform(0.001, 0.01)
            z = np.sqrt(share) * common + np.sqrt(1 - share) * rng.standard_normal()
            error_m = factor * std_m * z + tape_m * rng.standard_normal()
            found.append(JudgedLength(f"room-{k}", float(error_m), Z95 * std_m, 0.95, tape_m))
    return found


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.5])
@pytest.mark.parametrize("tape_m", [0.0, 0.005], ids=["exact", "tape"])
def test_the_factor_is_found_within_its_uncertainty(factor, tape_m):
    found = calibrate(lengths(60, factor, np.random.default_rng(1), tape_m=tape_m))
    assert found.factor_low < factor < found.factor_high
    # 60 rooms, half of each room's error in common: some 100 independent errors, 7 % of the factor each way.
    assert found.factor == pytest.approx(factor, rel=0.4)


def test_the_uncertainty_of_the_factor_is_right():
    """Of 40 studies with 12 rooms each, 95 % hold the truth; 4 standard errors are 14 %."""
    rng = np.random.default_rng(2)
    studies = [calibrate(lengths(12, 1.5, rng, per_room=3)) for _ in range(40)]
    held = np.mean([study.factor_low < 1.5 < study.factor_high for study in studies])
    assert held >= 0.95 - 0.14


def test_the_factor_scales_with_the_errors():
    sample = lengths(20, 1.0, np.random.default_rng(3))
    doubled = [replace(length, error_m=2.0 * length.error_m) for length in sample]
    # Two optimisations to 1e-6 in the logarithm.
    assert calibrate(doubled).factor == pytest.approx(2.0 * calibrate(sample).factor, rel=1e-4)


def test_too_narrow_intervals_hold_after_calibration_in_rooms_not_learnt_from():
    found = calibrate(lengths(60, 3.0, np.random.default_rng(4)))
    assert found.held_before < 0.6
    assert found.held_after == pytest.approx(0.95, abs=0.06)
    assert found.says == "The intervals are too narrow."


def test_too_few_rooms_are_refused_and_conformal_needs_nineteen():
    rng = np.random.default_rng(5)
    with pytest.raises(InputError, match="at least 5"):
        calibrate(lengths(4, 1.0, rng))
    assert calibrate(lengths(18, 1.0, rng)).conformal is None
    enough = calibrate(lengths(19, 1.0, rng))
    assert enough.conformal_rooms == 19
    assert enough.conformal is not None
    with pytest.raises(InputError, match="needs 19"):
        preset_toml(calibrate(lengths(18, 1.0, rng)), {}, conformal=True)


def test_several_levels_are_refused():
    sample = lengths(6, 1.0, np.random.default_rng(6))
    with pytest.raises(InputError, match="levels"):
        calibrate([replace(sample[0], level=0.8), *sample[1:]])


def test_the_conformal_factor_holds_what_it_promises():
    """Over 1000 studies of 19 rooms with gross errors, a new room's length is held with at least 95 %."""
    rng = np.random.default_rng(7)

    def gross(n):
        # Cauchy errors: no noise model would hold them.
        return [JudgedLength(f"r{k}", float(rng.standard_cauchy()), 1.0, 0.95, 0.0) for k in range(n)]

    held = []
    for k in range(1000):
        factor, _ = conformal_factor(gross(19), seed=k)
        assert factor is not None
        held.append(abs(gross(1)[0].error_m) <= factor)
    # Four standard errors of a share of 0.95 in 1000.
    assert np.mean(held) >= 0.95 - 4 * np.sqrt(0.95 * 0.05 / 1000)


@pytest.mark.parametrize("conformal", [False, True], ids=["likely", "conformal"])
def test_the_preset_loads_and_multiplies_what_was_there(conformal):
    import tomllib

    found = calibrate(lengths(30, 1.3, np.random.default_rng(8)))
    settings = {"seed": 4, "belief": {"inflation": 2.0, "wall_field": {"tau_median_m": 0.001}}}
    config = config_from_dict(tomllib.loads(preset_toml(found, settings, conformal)))
    wanted = found.conformal if conformal else found.factor
    assert wanted is not None
    # Written with four digits, rounded up.
    assert config.belief.inflation == pytest.approx(2.0 * wanted, rel=1e-3)
    assert config.belief.inflation >= 2.0 * wanted
    assert config.level == 0.95
    assert (config.seed, config.belief.wall_field.tau_median_m) == (4, 0.001)
