"""One scan fitted both ways: the joint fit beside the greedy baseline."""

from dataclasses import dataclass, replace

from indoorfit.config import RunConfig
from indoorfit.errors import IndoorfitError, InputError
from indoorfit.evaluate import Comparison, compare
from indoorfit.model import FitResult, Method, Scan

from .fit import fit_scan


@dataclass(frozen=True)
class Versus:
    """What the two ways of fitting say of one scan."""

    joint: FitResult | None
    greedy: FitResult | None
    matched: Comparison | None
    """The greedy model judged as if the joint one were the truth; None unless there are both."""
    refusals: dict[Method, str]
    """Why there is no model, for a way of fitting that has none."""


def fit_both(scan: Scan, config: RunConfig | None = None) -> Versus:
    """Fit a scan jointly and greedily, with the same settings otherwise, and without textures.

    Args:
        scan: metres, any pose.
        config: settings; its `method` is not used.

    Raises:
        InputError: neither way finds a room; the message is that of the joint fit.
    """
    config = config or RunConfig()
    # A comparison of numbers; painting would take longer than the rest.
    config = replace(config, texture=replace(config.texture, enabled=False))
    results: dict[Method, FitResult] = {}
    refusals: dict[Method, str] = {}
    methods: tuple[Method, ...] = ("joint", "greedy")
    for method in methods:
        try:
            results[method] = fit_scan(scan, replace(config, method=method))
        except IndoorfitError as error:
            refusals[method] = str(error)
    if not results:
        raise InputError(refusals["joint"])
    joint, greedy = results.get("joint"), results.get("greedy")
    matched = None if joint is None or greedy is None else compare(greedy, joint)
    return Versus(joint, greedy, matched, refusals)
