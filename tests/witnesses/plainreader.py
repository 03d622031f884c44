"""Reads a formula in plain text back into an expression, knowing nothing of the writer."""

from __future__ import annotations

import re
from collections.abc import Mapping

import sympy as sp
from sympy import Expr, I, Rational, Symbol, pi

_TOKEN = re.compile(r" *(?:(\d+\.?\d*(?:e-?\d+)?)|([^\W\d]\w*)|( - | \+ |[-*/^()|]))")
_FUNCTIONS = {x: getattr(sp, x) for x in ("exp", "cos", "sin", "cosh", "sinh", "asin", "acos", "atan", "sqrt")} | {
    "abs": sp.Abs
}


def expression(text: str, known: Mapping[str, Symbol]) -> Expr:
    """The expression that a line of text stands for; ``known`` maps names to symbols."""
    tokens, at = [], 0
    while at < len(text):
        match = re.compile(r" ([-+]) |").match(text, at)
        if match and match[1]:
            tokens.append(match[1])
        else:
            match = _TOKEN.match(text, at)
            assert match, f"cannot read {text[at : at + 30]}"
            tokens.append(match[1] or match[2] or match[3])
        at = match.end()
    reader = _Reader(tokens, known)
    result = reader.sum()
    assert not reader.tokens, f"cannot read on at {reader.tokens[:5]}"
    return result


class _Reader:
    def __init__(self, tokens: list[str], known: Mapping[str, Symbol]) -> None:
        self.tokens = tokens
        self.known = {**known, "pi": pi, "j": I}
        self.bars = 0

    def peek(self) -> str:
        return self.tokens[0] if self.tokens else ""

    def take(self, expected: str | None = None) -> str:
        token = self.tokens.pop(0)
        assert expected in (None, token)
        return token

    def sum(self) -> Expr:
        total = -self.product() if self.peek() == "-" and self.take() else self.product()
        while self.peek() in ("+", "-"):
            total += self.product() if self.take() == "+" else -self.product()
        return total

    def product(self) -> Expr:
        result = self.power()
        while self.peek() not in ("", "+", "-", ")") and not (self.peek() == "|" and self.bars):
            if self.peek() == "/":
                self.take()
                result /= self.power()
                assert self.peek() in ("", "+", "-", ")", "|"), "a quotient stands last"
            else:
                if self.peek() == "*":
                    self.take()
                result *= self.power()
        return result

    def power(self) -> Expr:
        base = self.atom()
        return base ** self.atom() if self.peek() == "^" and self.take() else base

    def atom(self) -> Expr:
        token = self.take()
        if token[0].isdigit():
            return Rational(token)
        if token == "(":
            return self.inside(")")
        if token == "|":
            self.bars += 1
            return sp.Abs(self.inside("|"))
        if token in _FUNCTIONS:
            self.take("(")
            return _FUNCTIONS[token](self.inside(")"))
        return self.known[token]

    def inside(self, closing: str) -> Expr:
        outer, self.bars = self.bars, int(closing == "|")
        result = self.sum()
        self.take(closing)
        self.bars = outer - (closing == "|")
        return result
