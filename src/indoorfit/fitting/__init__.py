"""Points and a grammar -> fitted planes with their uncertainty."""

from .association import AssociationConfig as AssociationConfig
from .association import associate as associate
from .association import claims as claims
from .belief import Belief as Belief
from .belief import BeliefConfig as BeliefConfig
from .belief import believe as believe
from .frames import cells_by_frame as cells_by_frame
from .greedy import GreedyConfig as GreedyConfig
from .greedy import GreedyFit as GreedyFit
from .greedy import fit_greedy as fit_greedy
from .honesty import Evidence as Evidence
from .honesty import HonestyConfig as HonestyConfig
from .honesty import honesty_notes as honesty_notes
from .intervals import MeasurandPrediction as MeasurandPrediction
from .joint import JointConfig as JointConfig
from .joint import JointFit as JointFit
from .joint import fit_joint as fit_joint
from .patches import PatchData as PatchData
from .residuals import build_cells as build_cells
from .uncertainty import Cells as Cells
from .uncertainty import SamplerConfig as SamplerConfig
from .uncertainty import TypeB as TypeB
from .uncertainty import TypeBConfig as TypeBConfig
from .uncertainty import type_b_of as type_b_of
