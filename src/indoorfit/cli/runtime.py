"""What every command sets up before it works."""

import logging
import sys


def set_up_logging(quiet: bool, verbose: bool) -> None:
    """Progress of indoorfit to standard error; of the libraries below only what is wrong."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("%(message)s"))
    logger = logging.getLogger("indoorfit")
    logger.handlers[:] = [handler]
    logger.propagate = False
    logger.setLevel(logging.WARNING if quiet else logging.DEBUG if verbose else logging.INFO)
