"""Checks certificates of haptisym against scene files: written from FORMAT.md alone,
with nothing of haptisym."""

from haptisym_check.proof import check
from haptisym_check.values import RefusedError, UnreadableError

__all__ = ["RefusedError", "UnreadableError", "check"]
