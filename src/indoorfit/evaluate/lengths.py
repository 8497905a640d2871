"""The lengths of a model against the true ones."""

from dataclasses import dataclass

from indoorfit.model import Dimension, DimensionKind, FitResult, PlaneStatus

from .intervals import interval_score


@dataclass(frozen=True)
class LengthCheck:
    """One true length and what the model says of it."""

    truth: str
    """Id of the true dimension; of several between the same two planes, the first."""
    model: str
    """Id of the model's dimension."""
    kind: DimensionKind
    true_m: float
    value_m: float
    std_m: float
    low_m: float
    high_m: float
    level: float
    """Nominal coverage of the interval."""
    status: PlaneStatus
    """What the model says the length rests on."""

    @property
    def error_m(self) -> float:
        """Model minus truth."""
        return self.value_m - self.true_m

    @property
    def hit(self) -> bool:
        """Whether the interval holds the truth."""
        return self.low_m <= self.true_m <= self.high_m

    @property
    def width_m(self) -> float:
        """Length of the interval."""
        return self.high_m - self.low_m

    @property
    def score_m(self) -> float:
        """Interval score (Gneiting & Raftery 2007); smaller is better."""
        return float(interval_score(self.low_m, self.high_m, self.true_m, self.level))


def check_lengths(
    model: FitResult, truth: FitResult, pairs: dict[str, str]
) -> tuple[tuple[LengthCheck, ...], tuple[str, ...]]:
    """Compare every true length, once for each pair of planes that it lies between.

    Args:
        model: what was found.
        truth: exact.
        pairs: the model's face for each true face that was found, in its place or not.

    Returns:
        the lengths that the model has a number for, and the ids of those that it has not.
    """
    found: dict[frozenset[int], Dimension] = {}
    for dimension in model.dimensions:
        found.setdefault(model.decided_by(dimension), dimension)
    checks, lost, done = [], [], set()
    for dimension in truth.dimensions:
        # Both long walls of a box and its overall extent are the same length: it counts once.
        planes = truth.decided_by(dimension)
        if planes in done:
            continue
        done.add(planes)
        counterpart = None
        faces = [*dimension.faces]
        if dimension.wall is not None and truth.face(dimension.wall).plane in planes:
            faces.append(dimension.wall)
        if all(face in pairs for face in faces):
            counterpart = found.get(frozenset(model.face(pairs[face]).plane for face in faces))
        if counterpart is None:
            lost.append(dimension.id)
        else:
            checks.append(_check(dimension, counterpart))
    return tuple(checks), tuple(lost)


def _check(true: Dimension, found: Dimension) -> LengthCheck:
    quantity = found.quantity
    return LengthCheck(
        truth=true.id,
        model=found.id,
        kind=true.kind,
        true_m=true.quantity.value,
        value_m=quantity.value,
        std_m=quantity.std,
        low_m=quantity.interval.low,
        high_m=quantity.interval.high,
        level=quantity.interval.level,
        status=found.status,
    )
