"""A fitted shape and its solids -> named faces, dimensions and their intervals."""

from .assemble import Verdict as Verdict
from .assemble import assemble as assemble
from .assemble import measurands as measurands
from .backing import backings as backings
from .backing import with_thicknesses as with_thicknesses
from .doors import find_doors as find_doors
from .evidence import FaceEvidence as FaceEvidence
from .evidence import by_face as by_face
from .evidence import with_status as with_status
from .levels import ExactPrediction as ExactPrediction
from .levels import at_level as at_level
from .named import Measurand as Measurand
from .named import Survey as Survey
from .remarks import face_notes as face_notes
from .survey import survey as survey
