"""Options that may be left out."""

from typing import Annotated, TypeVar

import tyro

_T = TypeVar("_T")

Maybe = Annotated[_T | None, tyro.conf.DisallowNone, tyro.conf.arg(help_behavior_hint="")]
"""``Maybe[Path] = None``: what happens without it stands in the option's own help, where tyro would say
``{None}|PATH`` and ``(default: None)``."""
