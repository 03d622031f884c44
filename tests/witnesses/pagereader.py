"""Reads a page strictly, and the equations on it as a computation, knowing nothing of the writer."""

from __future__ import annotations

import cmath
import math
import re
import unicodedata
from collections.abc import Mapping
from html.parser import HTMLParser
from xml.etree import ElementTree

MATH = "{http://www.w3.org/1998/Math/MathML}"
_EMPTY = ("meta", "input", "br", "hr", "link", "img")
_LOADS = (
    "src",
    "href",
    "srcset",
    "data",
    "poster",
    "action",
    "formaction",
    "xlink:href",
    "background",
    "cite",
    "manifest",
)


class Page(HTMLParser):
    """A page whose elements must be nested as written, each id once; ``numbers`` are the values of its data elements."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.ids: list[str] = []
        self.labels: list[str] = []
        self.controls: list[dict[str, str | None]] = []
        self.loads: list[str] = []
        self.numbers: list[float] = []
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        assert len(given) == len(attrs), (tag, attrs)
        self.tags.append(tag)
        if tag not in _EMPTY:
            self.open.append(tag)
        if given.get("id"):
            self.ids.append(str(given["id"]))
        if tag == "label":
            self.labels.append(str(given["for"]))
        if tag in ("input", "button"):
            self.controls.append(given)
        if tag == "data":
            self.numbers.append(float(str(given["value"])))
        self.loads += [str(value) for name, value in attrs if name in _LOADS and not str(value).startswith("#")]
        self.loads += re.findall(r"url\(([^#)][^)]*)\)", " ".join(str(value) for value in given.values()))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in _EMPTY:
            self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> ends nothing"
        assert self.open.pop() == tag, tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "style":
            self.loads += re.findall(r"@import.*|url\([^)]*\)", data)
        if not self.open or self.open[-1] not in ("script", "style"):
            self.texts.append(data)


# Equations.


def equations(page: str) -> list[tuple[str, list[tuple[str, str]]]]:
    """Each equation of the page's displays: the name on its left, and each relation with the side after it, as Python."""
    found: list[tuple[str, list[tuple[str, str]]]] = []
    for text in re.findall(r'<math [^>]*display="block">.*?</math>', page, re.DOTALL):
        for row in ElementTree.fromstring(text).iter(f"{MATH}mtr"):
            left, right = row
            name, (first, *sides) = _spelt(left), _sides(right)
            if name:
                assert not first[1]
                found.append((name, sides))
            else:  # the line goes on
                relation, start = found[-1][1][-1]
                found[-1][1][-1] = (relation, start + first[1])
                found[-1][1].extend(sides)
    return found


def value(side: str, known: Mapping[str, complex]) -> complex:
    """The value of a side of an equation."""
    functions = {name: getattr(cmath, name) for name in ("sqrt", "exp", "cos", "sin", "cosh", "sinh")}
    functions |= {"arctan": cmath.atan, "atan2": lambda y, x: math.atan2(y.real, x.real)}
    bars = iter(["abs(", ")"] * side.count("|"))
    code = re.sub(r"\|", lambda _: next(bars), side)
    # what is evaluated is the page that the test wrote
    return complex(eval(code, {"__builtins__": {}}, {**functions, "abs": abs, "pi": math.pi, "j": 1j, **known}))  # noqa: S307


def _sides(cell: ElementTree.Element) -> list[tuple[str, str]]:
    """Each relation of a line with what comes after it; what comes before the first has none."""
    [row] = cell
    sides = [("", "")]
    for item in row:
        if item.tag == f"{MATH}mo" and item.text in ("=", "≈"):
            sides.append((item.text, ""))
        else:
            sides[-1] = (sides[-1][0], sides[-1][1] + code(item))
    return sides


_SIGNS = {
    "−": "-",
    "⋅": "*",
    "×": "*",
    "\u2062": "*",
    "\u2061": "",
    "+": "+",
    "(": "(",
    ")": ")",
    "/": "/",
    "|": "|",
    ",": ",",
}


def code(item: ElementTree.Element) -> str:
    """An element as Python."""
    tag, children = item.tag.removeprefix(MATH), list(item)
    if tag == "mo":
        return _SIGNS[str(item.text)]
    if tag == "mn":
        return str(item.text)
    if tag in ("mi", "msub"):
        return _spelt(item)
    if tag == "mspace":
        return ""
    if tag == "mfrac":
        return f"(({code(children[0])})/({code(children[1])}))"
    if tag == "msqrt":
        return f"sqrt({''.join(map(code, children))})"
    if tag == "msup" and children[0].text == "e":
        return f"exp({code(children[1])})"
    if tag == "msup":
        return f"({code(children[0])})**({code(children[1])})"
    if tag == "msubsup":
        return f"({_spelt(children[0])}_{_spelt(children[1])})**({code(children[2])})"
    assert tag in ("mrow", "mstyle"), tag
    if len(children) == 3 and children[1].text == "\u2061" and children[0].tag == f"{MATH}msup":
        function, exponent = children[0]
        return f"({code(function)}{code(children[2])})**({code(exponent)})"
    return "".join(map(code, children))


def _spelt(item: ElementTree.Element) -> str:
    """A name as one word: subscripts after a low line, Greek letters spelt, operators and arguments dropped or joined."""
    if item.tag == f"{MATH}msub":
        head, below = item
        return f"{_spelt(head)}_{_spelt(below)}"
    if item.tag == f"{MATH}mfrac":
        above, below = item
        return f"{_spelt(above)}/{_spelt(below)}"
    if len(item):
        return "".join(_spelt(x) for x in item)
    return "".join(map(_letter, item.text or "")) if item.tag != f"{MATH}mo" or item.text == "|" else ""


def _letter(c: str) -> str:
    name = unicodedata.name(c, "")
    if name.startswith("GREEK"):
        word = name.split()[-1].lower().replace("lamda", "lambda")
        return word.capitalize() if "CAPITAL" in name else word
    return unicodedata.normalize("NFKC", c).replace("\xa0", "_").replace(" ", "_")
