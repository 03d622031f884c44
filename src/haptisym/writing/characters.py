"""Which characters of a scene or a file leave the program: none that controls a terminal or turns
text around."""

from __future__ import annotations

from unicodedata import category

MISSING = "\N{REPLACEMENT CHARACTER}"
"""What stands in the place of a character that is not shown."""
# Unicode's categories of controls, formats (overrides of direction among them), unassigned code
# points, surrogates, and separators of lines and paragraphs.
_HIDDEN = ("Cc", "Cf", "Cn", "Cs", "Zl", "Zp")
# Formats that Persian and Indic scripts are written with, and the ends of lines.
_HARMLESS = "\n\t\N{SOFT HYPHEN}\N{ZERO WIDTH NON-JOINER}\N{ZERO WIDTH JOINER}"


def is_hidden(c: str) -> bool:
    """Whether a character acts instead of being seen.

    Such are controls (C0 and C1), overrides of direction, separators of lines, and what is no
    character. What shapes the letters of a script stays, and so do the ends of lines.
    """
    return not c.isprintable() and c not in _HARMLESS and category(c) in _HIDDEN


def printable(text: str) -> str:
    r"""A text in which each hidden character is replaced, so that it is seen that one was there.

    >>> printable("5\x1b[2K \u202e950 rad/s")
    '5\ufffd[2K \ufffd950 rad/s'
    """
    return text if text.isprintable() else "".join(MISSING if is_hidden(c) else c for c in text)
