"""``python -m haptisym`` is ``haptisym``."""

from haptisym.cli import main

main()
