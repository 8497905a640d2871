"""``python -m indoorfit``."""

from indoorfit.cli.main import main

main()
