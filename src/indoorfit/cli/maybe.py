"""Options that may be left out, and what their help says of that."""

from typing import Annotated, TypeVar

import tyro

_T = TypeVar("_T")

Maybe = Annotated[_T | None, tyro.conf.DisallowNone, tyro.conf.arg(help_behavior_hint="")]
"""``Maybe[Path] = None``: what happens without it stands in the option's own help, where tyro would say
``{None}|PATH`` and ``(default: None)``."""

Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
"""``Flag = False``: that a flag is off unless given needs no ``(default: False)``."""
Quiet = Annotated[bool, tyro.conf.arg(aliases=["-q"], help_behavior_hint="")]
Verbose = Annotated[bool, tyro.conf.arg(aliases=["-v"], help_behavior_hint="")]
