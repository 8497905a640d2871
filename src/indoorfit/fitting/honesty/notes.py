"""All tests of the intervals' assumptions, in the order in which they are reported."""

from indoorfit.model import Frame, Note, Scan

from ..association import AssociationConfig
from ..uncertainty import WallFieldConfig
from .blocks import block_notes
from .config import HonestyConfig
from .evidence import Evidence, face_points
from .flatness import flatness_notes
from .layers import layer_notes
from .scatter import misfit_notes, prior_notes, seen_notes


def honesty_notes(
    scan: Scan,
    frame: Frame,
    evidence: Evidence,
    association: AssociationConfig,
    field: WallFieldConfig,
    config: HonestyConfig,
) -> tuple[Note, ...]:
    """Warn where an assumption of the intervals does not hold.

    Args:
        scan: metres, scan frame.
        frame: fitted.
        evidence: the fitted model and its residuals.
        association: which points a plane may claim.
        field: priors of the wall field.
        config: thresholds.
    """
    points = face_points(scan, frame, evidence.shape, association, config.max_points)
    return (
        *block_notes(evidence, points, config),
        *layer_notes(evidence, points, config),
        *flatness_notes(evidence, config, field),
        *seen_notes(evidence, config),
        *misfit_notes(evidence, config),
        *prior_notes(evidence),
    )
