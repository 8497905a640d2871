"""``indoorfit completion``: words that the shell completes."""

from dataclasses import dataclass
from typing import Literal

import tyro


@dataclass(frozen=True)
class CompletionCommand:
    """Print a completion script for a shell.

    bash: indoorfit completion bash > ~/.local/share/bash-completion/completions/indoorfit
    zsh:  indoorfit completion zsh > DIR/_indoorfit, DIR in $fpath
    fish: indoorfit completion fish > ~/.config/fish/completions/indoorfit.fish
    """

    shell: tyro.conf.Positional[Literal["bash", "zsh", "fish"]]
    """The shell that it is for."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        # Here, for the list of commands holds this one.
        from .main import parse

        parse(["--tyro-print-completion", self.shell])
        return 0
