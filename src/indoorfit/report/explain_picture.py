"""The plan with everything that decided it: cells, candidates, outline, points."""

import numpy as np
from jaxtyping import Float

from indoorfit.discover import CandidateReport, Explanation
from indoorfit.model import Frame

from .board import Board
from .display import Dots, Item, Label, Picture, Region, Stroke

_INK, _QUIET, _PAPER, _POINTS = "#2a2d30", "#6a7076", "#ffffff", "#b4b8bc"
_SEEN, _INFERRED, _OUTLINE = "#1f5f8b", "#c8601a", "#1d2b36"
_PASSED = "#3d8f5a"
_PASSED_SHARE = 0.3
"""Of a border: half of the band under the ceiling, which counts 0.6 of a wall."""
_INSIDE, _OUTSIDE = np.array([126.0, 178.0, 224.0]), np.array([242.0, 178.0, 120.0])
_FULL_NATS_M2 = 20.0
"""Log odds per square metre at which a tint is full: a ceiling seen whole gives 32, one unseen minus 9."""
_LARGEST = 760.0
_MARGIN, _HEAD, _ROW = 28.0, 84.0, 13.0
_ROWS = 12
"""Of identifiers above each other, where candidates are close."""
_CLEAR_M = 0.3
"""Points nearer than this to floor and ceiling hide the walls from above."""
_DOT = 2.0


def explain_picture(found: Explanation, frame: Frame, points_m: Float[np.ndarray, "points 3"]) -> Picture:
    """Draw the plan from above, x to the right and y up.

    Args:
        found: the decision and its reasons.
        frame: of the explanation, in the scan.
        points_m: the scan, scan frame, metres.
    """
    low = np.array([line[0] for line in found.grid])
    high = np.array([line[-1] for line in found.grid])
    scale = _LARGEST / float(np.max(high - low))
    size = (high - low) * scale
    ids_left, ids_top = _lettered(found, low, high, scale)
    left, top = _left(ids_left), _left(ids_top, upright=True)
    corner = np.array([_MARGIN + left, _HEAD + top])

    def page(xy_m: np.ndarray) -> np.ndarray:
        return np.stack([(xy_m[:, 0] - low[0]) * scale, (high[1] - xy_m[:, 1]) * scale], axis=1)

    drawing: list[Item] = [*_cells(found, page), *_dots(found, frame, points_m, page, size)]
    drawing += [_line(candidate, low, high, page) for candidate in found.candidates]
    drawing += [Stroke(page(ends), _PASSED, 3.0, (4.0, 4.0)) for ends in _passed(found)]
    drawing += [Stroke(page(ends), _OUTLINE, 4.5) for ends in _outline(found)]
    drawing += _oblique(found, page)
    drawing += [*ids_left, *ids_top]
    width = max(corner[0] + size[0] + _MARGIN, 720.0)
    passed = found.evidence.free is not None
    items = (
        Label("Why the plan is as it is", (_MARGIN, _MARGIN + 6.0), 18.0, _INK, "start"),
        *_legend(_MARGIN, _MARGIN + 34.0, passed),
        *(item.moved(corner) for item in drawing),
    )
    about = f"{len(found.candidates)} candidates for walls, and the cells between them by their evidence."
    height = corner[1] + size[1] + _MARGIN
    return Picture(float(width), float(height), _PAPER, items, "Explanation of the plan", about)


def _cells(found: Explanation, page) -> list[Item]:
    area_m2 = np.outer(*(np.diff(line) for line in found.grid))
    strength = np.clip(found.log_odds / area_m2 / _FULL_NATS_M2, -1.0, 1.0)
    items: list[Item] = []
    for i, j in np.ndindex(found.room.shape):
        tint = _INSIDE if strength[i, j] > 0 else _OUTSIDE
        share = 0.75 * abs(float(strength[i, j]))
        colour = "#{:02x}{:02x}{:02x}".format(*(int(c) for c in 255.0 + share * (tint - 255.0)))
        x, y = found.grid[0][[i, i + 1]], found.grid[1][[j, j + 1]]
        ring = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
        items.append(Region((page(ring),), colour))
    return items


def _dots(
    found: Explanation, frame: Frame, points_m: Float[np.ndarray, "points 3"], page, size: np.ndarray
) -> list[Item]:
    """Points between floor and ceiling, one per small square of the page."""
    manhattan = frame.to_manhattan(points_m)
    clear = (manhattan[:, 2] > found.heights_m[0] + _CLEAR_M) & (
        manhattan[:, 2] < found.heights_m[1] - _CLEAR_M
    )
    at = page(manhattan[clear, :2])
    at = at[np.all((at > -6.0) & (at < size + 6.0), axis=1)]
    centres = (np.unique(np.floor(at / _DOT).astype(int), axis=0) + 0.5) * _DOT
    return [Dots(centres, _POINTS, 1.4)] if len(centres) else []


def _line(candidate: CandidateReport, low: np.ndarray, high: np.ndarray, page) -> Item:
    """A candidate over the whole plan: solid where wall was seen on it, dotted where it was inferred."""
    ends = np.array([low, high])
    ends[:, candidate.axis] = candidate.position_m
    width = 1.6 if candidate.verdict == "accepted" else 0.9
    colour, dash = (_SEEN, None) if candidate.seen else (_INFERRED, (2.0, 3.0))
    return Stroke(page(ends), colour, width, dash)


def _oblique(found: Explanation, page) -> list[Item]:
    """The oblique lines as far as they were seen, where rooms end on them, and their identifiers."""
    items: list[Item] = []
    for k, trial in enumerate(found.oblique, start=1):
        items.append(Stroke(page(trial.line.ends_m), _SEEN, 1.6 if trial.accepted else 0.9))
        if trial.accepted and trial.cut is not None:
            items.append(Stroke(page(trial.cut.corner.corners_m[:2]), _OUTLINE, 4.5))
        x, y = page(trial.line.ends_m).mean(axis=0).tolist()
        items.append(Label(f"o{k}", (x, y - _ROW), 11.0, _INK if trial.accepted else _QUIET, halo=_PAPER))
    return items


def _outline(found: Explanation) -> list[np.ndarray]:
    """The borders on which rooms end, as pairs of points; not behind the oblique walls."""
    corners = [trial.cut.corner for trial in found.oblique if trial.accepted and trial.cut is not None]
    padded = np.pad(found.room, 1)
    across_y = np.argwhere(padded[1:-1, 1:] != padded[1:-1, :-1])[:, ::-1]
    pairs: list[np.ndarray] = []
    for axis, borders in enumerate((np.argwhere(padded[1:, 1:-1] != padded[:-1, 1:-1]), across_y)):
        for i, j in borders.tolist():
            at_m, stretch = float(found.grid[axis][i]), found.grid[1 - axis][j : j + 2]
            stretches = [(float(stretch[0]), float(stretch[1]))]
            for corner in corners:
                start_m, end_m = corner.chord_m(axis, at_m)
                if start_m == end_m:
                    continue
                cut = [((low, min(high, start_m)), (max(low, end_m), high)) for low, high in stretches]
                stretches = [left for pair in cut for left in pair if left[0] < left[1]]
            ends = [np.array([[at_m, low], [at_m, high]]) for low, high in stretches]
            pairs += [end if axis == 0 else end[:, ::-1] for end in ends]
    return pairs


def _passed(found: Explanation) -> list[np.ndarray]:
    """The borders that lines of sight pass below the ceiling, as pairs of points."""
    free, (x, y) = found.evidence.free, found.grid
    if free is None:
        return []
    pairs = [
        np.array([[x[i], y[j]], [x[i], y[j + 1]]]) for i, j in np.argwhere(free.walls[0] > _PASSED_SHARE)
    ]
    return pairs + [
        np.array([[x[i], y[j]], [x[i + 1], y[j]]]) for i, j in np.argwhere(free.walls[1] > _PASSED_SHARE)
    ]


def _lettered(
    found: Explanation, low: np.ndarray, high: np.ndarray, scale: float
) -> tuple[list[Label], list[Label]]:
    """The identifiers: of y to the left of the plan, of x above it, each in the nearest row with space."""
    board, by_axis = Board(), ([], [])
    for candidate in found.candidates:
        for row in range(_ROWS):
            away = 12.0 + row * (2.0 * _ROW if candidate.axis == 1 else _ROW)
            at = (
                ((candidate.position_m - low[0]) * scale, -away)
                if candidate.axis == 0
                else (-away, (high[1] - candidate.position_m) * scale)
            )
            bold = candidate.verdict == "accepted"
            label = Label(candidate.id, at, 11.0, _INK if bold else _QUIET, halo=_PAPER)
            if not board.hits("text", [label.box()], 1.0) or row == _ROWS - 1:
                board.add("text", [label.box()])
                by_axis[candidate.axis].append(label)
                break
    return by_axis[1], by_axis[0]


def _left(labels: list[Label], upright: bool = False) -> float:
    """How far the identifiers reach beyond the plan."""
    return max((-label.box()[1 if upright else 0] for label in labels), default=0.0)


def _legend(x: float, y: float, passed: bool) -> list[Item]:
    entries = [
        ("room ends here", Stroke(np.array([[0.0, 0.0], [30.0, 0.0]]), _OUTLINE, 4.5)),
        ("wall seen", Stroke(np.array([[0.0, 0.0], [30.0, 0.0]]), _SEEN, 1.6)),
        ("inferred", Stroke(np.array([[0.0, 0.0], [30.0, 0.0]]), _INFERRED, 1.6, (2.0, 3.0))),
        ("evidence for inside", _swatch("#9ec5e8")),
        ("for outside", _swatch("#f5c594")),
    ]
    if passed:
        stroke = Stroke(np.array([[0.0, 0.0], [30.0, 0.0]]), _PASSED, 3.0, (4.0, 4.0))
        entries.append(("looked through", stroke))
    items: list[Item] = []
    for text, sample in entries:
        label = Label(text, (x + 36.0, y), 11.0, _INK, "start")
        items += [sample.moved(np.array([x, y])), label]
        x = label.box()[2] + 18.0
    return items


def _swatch(colour: str) -> Region:
    ring = np.array([[10.0, -7.0], [30.0, -7.0], [30.0, 7.0], [10.0, 7.0]])
    return Region((ring,), colour)
