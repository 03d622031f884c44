"""``python -m haptisym`` is ``haptisym``."""

from .cli import main

main()
