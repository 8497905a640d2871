"""From cells of residuals to intervals that can be believed (no JAX in here)."""

from .cells import Cells as Cells
from .cells import Contrasts as Contrasts
from .chains import ChainDiagnostics as ChainDiagnostics
from .chains import SamplerConfig as SamplerConfig
from .clusters import ClusterRobust as ClusterRobust
from .clusters import cluster_robust as cluster_robust
from .clusters import independent_points as independent_points
from .clusters import point_noise_floor as point_noise_floor
from .fusion import FusedPredictive as FusedPredictive
from .fusion import FusionConfig as FusionConfig
from .fusion import fuse as fuse
from .hyper_sampler import SampledPredictive as SampledPredictive
from .hyper_sampler import sample_wall_field as sample_wall_field
from .pose_field import FrameSlips as FrameSlips
from .pose_field import PoseFieldConfig as PoseFieldConfig
from .pose_field import pose_field_predictive as pose_field_predictive
from .pose_field import pose_obstacle as pose_obstacle
from .predictive import DerivedQuantities as DerivedQuantities
from .predictive import Distribution as Distribution
from .predictive import Predictive as Predictive
from .type_b import ExpandedUncertainty as ExpandedUncertainty
from .type_b import TypeBConfig as TypeBConfig
from .type_b import expand_dimensions as expand_dimensions
from .type_b import expand_ends as expand_ends
from .wall_field import WallFieldConfig as WallFieldConfig
from .wall_field import wall_field_predictive as wall_field_predictive
