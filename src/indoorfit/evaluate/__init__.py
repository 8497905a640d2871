"""A model against the truth, or against another model: structure, lengths, intervals, surfaces."""

from .comparison import Comparison as Comparison
from .comparison import compare as compare
from .intervals import Coverage as Coverage
from .intervals import coverage as coverage
from .intervals import interval_score as interval_score
from .intervals import reliability as reliability
from .intervals import wilson as wilson
from .isprs import IsprsCurves as IsprsCurves
from .isprs import accuracy_m as accuracy_m
from .isprs import completeness as completeness
from .isprs import correctness as correctness
from .isprs import isprs_curves as isprs_curves
from .lengths import LengthCheck as LengthCheck
from .matching import Misplaced as Misplaced
from .matching import RoomPair as RoomPair
from .summary import Summary as Summary
from .summary import summarise as summarise
from .tape import check_tape as check_tape
from .tape import combine as combine
from .tape import tape_notes as tape_notes
