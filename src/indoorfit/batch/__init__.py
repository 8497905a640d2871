"""Many scans at once: against truth, against tape measurements, greedy against joint."""

from indoorfit.environment import prepare_numerics

# Workers of a cluster come in by this door, and the numerics look at the environment when they are loaded.
prepare_numerics()

from .calibration import Calibration as Calibration  # noqa: E402
from .calibration import JudgedLength as JudgedLength  # noqa: E402
from .calibration import calibrate as calibrate  # noqa: E402
from .calibration import calibrate_groups as calibrate_groups  # noqa: E402
from .collect import Tables as Tables  # noqa: E402
from .collect import collect as collect  # noqa: E402
from .jobs import Job as Job  # noqa: E402
from .jobs import ScanFile as ScanFile  # noqa: E402
from .jobs import Simulation as Simulation  # noqa: E402
from .manifest import Study as Study  # noqa: E402
from .manifest import read_manifest as read_manifest  # noqa: E402
from .page import view as view  # noqa: E402
from .pool import Limits as Limits  # noqa: E402
from .preset import preset_toml as preset_toml  # noqa: E402
from .preset import read_lengths as read_lengths  # noqa: E402
from .preset import scales_toml as scales_toml  # noqa: E402
from .reliability import reliability_of as reliability_of  # noqa: E402
from .run import RunOptions as RunOptions  # noqa: E402
from .run import run_batch as run_batch  # noqa: E402
from .scales import NoiseScales as NoiseScales  # noqa: E402
from .scales import learn_scales as learn_scales  # noqa: E402
from .write import write_tables as write_tables  # noqa: E402
