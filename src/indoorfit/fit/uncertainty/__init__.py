"""From cells of residuals to intervals that can be believed (no JAX in here)."""

from .cells import Cells as Cells
from .cells import Contrasts as Contrasts
from .predictive import DerivedQuantities as DerivedQuantities
from .predictive import Distribution as Distribution
from .predictive import Predictive as Predictive
from .wall_field import WallFieldConfig as WallFieldConfig
from .wall_field import wall_field_predictive as wall_field_predictive
