"""A fitted shape and its solids -> named faces, dimensions and their intervals."""

from .assemble import PlaneEvidence as PlaneEvidence
from .assemble import Verdict as Verdict
from .assemble import assemble as assemble
from .assemble import measurands as measurands
from .backing import backings as backings
from .backing import with_thicknesses as with_thicknesses
from .doors import find_doors as find_doors
from .levels import ExactPrediction as ExactPrediction
from .levels import at_level as at_level
from .named import Measurand as Measurand
from .named import Survey as Survey
from .remarks import face_notes as face_notes
from .survey import survey as survey
