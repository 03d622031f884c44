"""HTML as a value: text is escaped by construction, and only what was built here is markup."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from types import MappingProxyType
from unicodedata import category

_EMPTY = frozenset(("meta", "input", "br", "hr"))  # elements that have no end
_NONE: Mapping[str, str] = MappingProxyType({})


class Html(str):
    """Markup. Whatever is not of this type is text, and is escaped where it enters an element."""

    __slots__ = ()


def element(tag: str, *children: str, given: Mapping[str, str] = _NONE) -> Html:
    """An element with its children and its attributes.

    children : ``Html`` stays as it is; any other text is escaped.
    given : attributes by name; their values are escaped.

    >>> element("p", "a < b ", element("em", "c"), given={"title": 'say "d"'})
    '<p title="say &quot;d&quot;">a &lt; b <em>c</em></p>'
    """
    attributes = "".join(f' {name}="{_printable(escape(value))}"' for name, value in given.items())
    if tag in _EMPTY:
        return Html(f"<{tag}{attributes}>")
    return Html(f"<{tag}{attributes}>{joined(children)}</{tag}>")


def joined(parts: Iterable[str], between: str = "") -> Html:
    """Texts and markup one after the other, as markup.

    >>> joined(["<", element("b", "x")], ", ")
    '&lt;, <b>x</b>'
    """
    return Html(_markup(between).join(map(_markup, parts)))


def _markup(text: str) -> str:
    return text if isinstance(text, Html) else _printable(escape(text))


def _printable(text: str) -> str:
    """Without the characters that no document may hold: controls, halves of surrogate pairs, and what is no character."""
    return "".join(c if c in "\n\t" or category(c) not in ("Cc", "Cs", "Cn") else "\ufffd" for c in text)


def script(text: str, given: Mapping[str, str] = _NONE) -> Html:
    r"""A script element, or data in one; nothing in its text, a string or a comment, can end it.

    >>> script('"</script><!--"')
    '<script>"<\\/script><\\!--"</script>'
    """
    harmless = text.replace("</", "<\\/").replace("<!--", "<\\!--")
    return element("script", Html(harmless), given=given)


def data(text: str, identity: str) -> Html:
    """JSON in a script element of that id."""
    harmless = text.replace("<", "\\u003c")
    return element("script", Html(harmless), given={"type": "application/json", "id": identity})
