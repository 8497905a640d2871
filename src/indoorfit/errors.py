"""Everything that a user can cause and mend.

A message has three parts: where, what was found against what is needed, and what to do. The command
line prints it as it stands and exits with 1; a traceback always means a fault of ours.
"""


class IndoorfitError(Exception):
    """Base of all errors that are the input's or the settings' and not ours."""


class InputError(IndoorfitError):
    """The scan cannot be read, or what was read cannot be a room."""


class ConfigError(IndoorfitError):
    """A setting is unknown or has an impossible value."""


class SamplingError(IndoorfitError):
    """Markov chains were asked for and have not converged, so there is nothing to report from them."""


class OutputError(IndoorfitError):
    """The result cannot be written where it should go."""
