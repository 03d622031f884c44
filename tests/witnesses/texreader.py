"""A second pair of eyes for LaTeX: it reads the printed formulas back and works them out, knowing nothing of the printer."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from math import asin, cos, cosh, exp, floor, pi, sin, sinh, sqrt

_SYMBOL = r"\\sum_\{i=1\}|(?:\\mathcal\{[A-Z]\}|\\mathrm\{[a-z]+\}|\\[A-Za-z]+|[A-Za-z])(?:_(?:\{(?:[^{}]|\{[^{}]*\})*\}|\\[A-Za-z]+|[A-Za-z0-9]))?"
_TOKEN = re.compile(
    rf"(?P<command>\\(?:frac|tfrac|sqrt|times|cdot|labs|rabs|cosh|sinh|cos|sin|arcsin|floor|max|min)(?![A-Za-z]))|(?P<number>\d+/\d+|\d+\.?\d*)"
    rf"|(?P<exp>e(?=\^))|(?P<symbol>{_SYMBOL})|(?P<other>[-+(){{}}^,])|\s+"
)
_FUNCTIONS = {
    r"\cosh": cosh, r"\sinh": sinh, r"\cos": cos, r"\sin": sin, r"\arcsin": asin, r"\floor": floor,
}  # fmt: skip
_OF_TWO = {r"\max": max, r"\min": min}


def value(text: str, known: Mapping[str, float]) -> float:
    """The value of a printed formula; ``known`` maps printed names, such as ``\\omega_n``, to numbers."""
    text = text.replace(r"\operatorname{floor}", r"\floor")
    for old, new in ((r"\left|", r"\labs "), (r"\right|", r"\rabs "), (r"\left(", "("), (r"\right)", ")"), ("{}", "")):
        text = text.replace(old, new)
    reader = _Reader(re.sub(r"\\[bB]ig[lr]", "", text), {r"\pi": pi, **known})
    result = reader.sum()
    assert reader.at == len(reader.tokens), f"cannot read on at {reader.tokens[reader.at :][:5]} in {text}"
    return result


def equations(aligned: str) -> dict[str, list[str]]:
    """The sides of each equation of an ``align*``, by the left one; broken lines are joined again."""
    body = re.sub(r"\\(begin|end)\{align\*\}", "", aligned)
    found: dict[str, list[str]] = {}
    last = ""
    for line in re.split(r"\\\\\n", body):
        left, _, right = line.partition("&")
        if left.strip():
            last = left.strip()
            found[last] = []
        if right.startswith((r"\quad", "{}")):
            found[last][-1] += " " + right.removeprefix(r"\quad")
        else:
            found[last] += [side.strip() for side in re.split(r"(?<!\\)(?<!_\{i)=|\\approx", right) if side.strip()]
    return found


class _Reader:
    def __init__(self, text: str, known: Mapping[str, float]) -> None:
        self.known = {**known}
        self.at = 0
        self.tokens: list[tuple[str, str]] = []
        place = 0
        while place < len(text):
            match = _TOKEN.match(text, place)
            assert match, f"cannot read {text[place : place + 30]}"
            if match.lastgroup:
                self.tokens.append((match.lastgroup, match[0]))
            place = match.end()

    def peek(self) -> str:
        return self.tokens[self.at][1] if self.at < len(self.tokens) else ""

    def take(self, expected: str | None = None) -> tuple[str, str]:
        token = self.tokens[self.at]
        assert expected in (None, token[1]), f"expected {expected}, found {token[1]}"
        self.at += 1
        return token

    def sum(self) -> float:
        total = 0.0
        while True:
            sign = 1
            while self.peek() in ("+", "-"):
                sign *= -1 if self.take()[1] == "-" else 1
            total += sign * self.product()
            if self.peek() not in ("+", "-"):
                return total

    def product(self) -> float:
        result = self.power()
        while self.peek() not in ("", "+", "-", ")", "}", ",", r"\rabs"):
            if self.peek() in (r"\times", r"\cdot"):
                self.take()
            result *= self.power()
        return result

    def power(self) -> float:
        if self.tokens[self.at][0] == "exp":
            self.take()
            self.take("^")
            return exp(self.group())
        base = self.atom()
        if self.peek() == "^":
            self.take()
            return float(base ** self.group())
        return base

    def summed(self, last: int) -> float:
        """The sum of the term that follows, read once for each i from 1 to the last."""
        start, total = self.at, 0.0
        for i in range(1, last + 1):
            self.at = start
            self.known["i"] = float(i)
            total += self.product()
        return total

    def group(self) -> float:
        self.take("{")
        text = self.peek()
        result = self.sum()
        self.take("}")
        assert text
        return result

    def atom(self) -> float:
        kind, text = self.take()
        if kind == "number":
            return float(Fraction(text))
        if text.startswith(r"\sum"):
            assert text == r"\sum_{i=1}"
            self.take("^")
            return self.summed(int(self.group()))
        if kind == "symbol":
            return self.known[text]
        if text in _OF_TWO:
            self.take("(")
            one = self.sum()
            self.take(",")
            other = self.sum()
            self.take(")")
            return _OF_TWO[text](one, other)
        if text in (r"\frac", r"\tfrac"):
            return self.group() / self.group()
        if text == r"\sqrt":
            return sqrt(self.group())
        if text in _FUNCTIONS:
            return float(_FUNCTIONS[text](self.atom()))
        closing = {"(": ")", r"\labs": r"\rabs"}[text]
        result = self.sum()
        self.take(closing)
        return abs(result) if text == r"\labs" else result
