"""What a scene file says: exact numbers, and the chain of its dynamics in Gaussian integers wherever it is asked for."""

import re
import tomllib
from collections.abc import Callable
from fractions import Fraction
from functools import cache, reduce
from math import comb, factorial
from operator import add, getitem
from pathlib import Path
from typing import Any, NamedTuple, TypeVar


class RefusedError(Exception):
    """What a certificate does not prove, or what is not understood."""


class UnreadableError(RefusedError):
    """There is nothing to check: a file is missing, or is no JSON (the certificate), no TOML (the scene)."""


def need(condition: object, why: str) -> None:
    """RefusedError, and why, unless the condition holds."""
    if not condition:
        raise RefusedError(why)


MOST_DELAYS, MOST_BITS = 4, 30_000
Degrees = tuple[int, ...]


def degree(place: int, n: int = 1) -> Degrees:
    """That of a power of one variable: s or omega is the first, pi the next, then tan(omega tau/2) of each delay."""
    return (0,) * place + (n,) + (0,) * (MOST_DELAYS + 1 - place)


class Value(NamedTuple):
    """A Gaussian integer, the value of a polynomial at some point, with bounds on its degrees in each variable."""

    re: int
    im: int = 0
    degrees: Degrees = degree(0, 0)

    def plus(self, x: "Value", sign: int = 1) -> "Value":
        """x + y, or x - y."""
        return Value(self.re + sign * x.re, self.im + sign * x.im, tuple(map(max, self.degrees, x.degrees)))

    def times(self, x: "Value") -> "Value":
        """x y."""
        re, im = self.re * x.re - self.im * x.im, self.re * x.im + self.im * x.re
        need(re.bit_length() + im.bit_length() < MOST_BITS, "a number is too large")
        return Value(re, im, tuple(map(add, self.degrees, x.degrees)))

    def power(self, n: int) -> "Value":
        """x^n for n >= 0."""
        return reduce(Value.times, [self] * n) if n else ONE

    def conjugate(self) -> "Value":
        """For s = j omega a polynomial in omega, of the same degree."""
        return Value(self.re, -self.im, self.degrees)


Ratio = tuple[Value, Value]  # a dynamics is numerator and denominator: nothing is divided, no polynomial written out
ONE, ZERO = Value(1), Value(0, 0, (-(10**6),) * (MOST_DELAYS + 2))  # the polynomial 0 has a degree below all others


class Point(NamedTuple):
    """Where a chain is computed: s, and whole numbers in place of pi and of tan(omega tau/2) of some delays tau."""

    s: Ratio
    pi: int
    delays: tuple[Fraction, ...] = ()
    tangents: tuple[int, ...] = ()

    def delayed(self, lag: Fraction) -> Value:
        """(1 - j t)^n, where exp(-s lag) = ((1 - j t)/(1 + j t))^n."""
        if not lag:
            return ONE
        i = next((i for i, tau in enumerate(self.delays) if lag % tau == 0), None)
        need(i is not None and lag / self.delays[i or 0] <= 64, "a delay: the proof has none that it is a multiple of")
        return Value(1, -self.tangents[i or 0], degree(2 + (i or 0))).power(int(lag / self.delays[i or 0]))


def combined(sign: str, x: Ratio, y: Ratio) -> Ratio:
    """x + y, x - y, x * y or x / y."""
    if sign in "*/":
        top, bottom = y if sign == "*" else y[::-1]
        return x[0].times(top), x[1].times(bottom)
    return x[0].times(y[1]).plus(y[0].times(x[1]), 1 if sign == "+" else -1), x[1].times(y[1])


T = TypeVar("T")
NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3}(?![0-9]))?"
POWER = r"(?:\^|\*\*)\s*(?:\(\s*[+-]?[0-9]{1,2}\s*\)|[+-]?[0-9]{1,2}(?![\w.]))"
WORD = re.compile(rf"{NUMBER}|[^\W\d]\w*|[°%]|{POWER}|[-+*/()]")
BINDS = {"+": 1, "-": 1, "*": 2, "/": 2}


@cache
def words_of(text: str) -> list[str]:
    """Numbers, names, signs and whole powers, in reverse."""
    found = WORD.findall(text) if len(text) <= 4000 else []
    whole = "".join("".join(found).split()) == "".join(text.split())
    need(found and len(found) <= 400 and whole, f"{text[:60]!r} is not understood")
    return found[::-1]


def evaluated(text: str, leaf: Callable[[str], T], combine: Callable[[str, T, T], T], *, spaced: bool = False) -> T:
    """A formula's value, from what numbers and names are and how two are combined; ``spaced``: N m is N*m."""
    words = [*words_of(text)]

    def value(least: int) -> T:
        """Of what signs hold together that bind more than that."""
        word = words.pop() if words else ")"
        if word in BINDS:
            need(BINDS[word] == 1, f"{text[:60]!r} is not understood")
            found = combine(word, leaf("0"), value(2))
        elif word == "(":
            found = value(0)
            need(words and words.pop() == ")", f"{text[:60]!r} is not understood")
        else:
            need(word[0] not in ")^*", f"{text[:60]!r} is not understood")
            found = leaf(word)
        if words and re.match(r"\^|\*\*", words[-1]):
            base, n, found = found, int(re.sub("[^-0-9]", "", words.pop())), leaf("1")
            for _ in range(abs(n)):
                found = combine("*" if n > 0 else "/", found, base)
        while words and words[-1] != ")":
            sign = words[-1] if words[-1] in BINDS else "*"
            if BINDS[sign] <= least:
                break
            unsaid = words[-1] != sign and (not spaced or (words[-1] != "1" and words[-1][0] in ".0123456789"))
            need(not unsaid, f"{text[:60]!r} is not understood")
            found = combine(sign, found, value(BINDS[words.pop() if words[-1] == sign else sign]))
        return found

    result = value(0)
    need(not words, f"{text[:60]!r} is not understood")
    return result


class Number(NamedTuple):
    """value * pi^pi, and its dimension, powers of kg, m and s; None without a unit."""

    value: Fraction
    pi: int = 0
    dimension: list[int] | None = None

    def at(self, pi: int) -> Ratio:
        """With a whole number in place of pi."""
        up, down = max(self.pi, 0), max(-self.pi, 0)
        top = Value(self.value.numerator * pi**up, 0, degree(1, up)) if self.value else ZERO
        return top, Value(self.value.denominator * pi**down, 0, degree(1, down))


FREE = Number(Fraction(1), 1)  # a parameter that is left free takes the place of pi
CATALOGUE = tomllib.loads((Path(__file__).parent / "catalogue.toml").read_text(encoding="utf-8"))
SPELLED: dict[int, str] = {ord(x): y for x, y in zip("·×⋅²³", ("*", "*", "*", "^2", "^3"), strict=True)}


def unit(word: str) -> Number:
    """A number, or a unit by its name, perhaps with a prefix."""
    if word[0] in ".0123456789":
        return Number(Fraction(word))
    prefix, base = ("", word) if word in CATALOGUE["units"] else (word[:1], word[1:])
    factor, pi, dimension, prefixed = CATALOGUE["units"].get(base, ["1", 0, [], ""])
    fits = dimension and (not prefix or (prefix in CATALOGUE["prefixes"] and prefixed))
    need(fits, f"the unit {word!r} is not understood")
    return Number(Fraction(factor) * Fraction(10) ** CATALOGUE["prefixes"].get(prefix, 0), pi, dimension)


def units(sign: str, x: Number, y: Number) -> Number:
    """The product or the quotient of two; 0 + y or 0 - y."""
    n = 1 if sign in "*+" else -1
    if sign in "+-":
        need(not x.value, "a quantity is a product of powers")
        return y._replace(value=n * y.value)
    need(n > 0 or y.value, "a division by zero")
    value = x.value * y.value**n
    need(value.numerator.bit_length() + value.denominator.bit_length() < 10**5, "a number is too large")
    both = [a + n * b for a, b in zip(x.dimension or [0, 0, 0], y.dimension or [0, 0, 0], strict=True)]
    return Number(value, x.pi + n * y.pi, None if x.dimension is y.dimension is None else both)


def quantity(given: Any, kind: str = "") -> Number:
    """A number with or without a unit, exactly; of a range the nominal value. ``kind``: a key of the dimensions."""
    if isinstance(given, list):
        need(2 <= len(given) <= 3, "a range has two ends, and perhaps its nominal value between them")
        low, *between, high = (quantity(x, kind) for x in given)
        need(low[1:] == high[1:], "the ends of a range have different units")
        return between[0] if between else low._replace(value=(low.value + high.value) / 2)
    if isinstance(given, Number):
        return given
    if isinstance(given, int | Fraction) and not isinstance(given, bool):
        return Number(Fraction(given))
    need(isinstance(given, str) and len(given) < 500, "a value is neither a number nor a text")
    text, *deviation = re.split(r"\+/?-|±", given)
    found = evaluated(text.translate(SPELLED), unit, units, spaced=True)
    fits = not kind or found.dimension is None or found.dimension in CATALOGUE["dimensions"][kind]
    need(fits and len(deviation) < 2, f"{given[:60]!r} has the wrong dimension")
    return found


def row(model: str, given: dict[str, Any]) -> list[str]:
    """That of the catalogue for these parameters; lists among them are taken apart."""
    if model == "prony":
        k, b = given.pop("k", None), given.pop("b", None)
        need(isinstance(k, list) and isinstance(b, list) and 0 < len(k) == len(b) <= 20, "k and b must be lists alike")
        given.update({f"{key}_{i}": x for key, xs in (("k", k), ("b", b)) for i, x in enumerate(xs, 1)})
        own = "".join(f" + k_{i}*b_{i}*s/(k_{i} + b_{i}*s)" for i in range(1, len(k) + 1))
        return [" ".join(["k0", *set(re.findall(r"[kb]_\d+", own))]), f"k0{own}"]
    if model == "pade-delay":
        n = given.pop("order", 0)
        need(type(n) is int and 1 <= n <= 10, "the order must be a whole number from 1 to 10")
        weights = [comb(n, i) * factorial(2 * n - i) for i in range(n + 1)]
        back, forth = (" + ".join(f"{c}*({x}s*tau)^{i}" for i, c in enumerate(weights)) for x in ("-", ""))
        return ["tau", back, "0", "0", forth]
    if model == "sampled-loop":
        method, n = given.pop("method", None), given.pop("delay", 0)
        need(type(n) is int and 0 <= n <= 20, "the delay must be a whole number of samples, from 0 to 20")
        need(isinstance(method, str) and method in CATALOGUE["clocks"], "the method of a clock is not understood")
        return ["T@1", f"u^{n}*(v - u)", "0", "0", f"s*T*v^{n + 1}", CATALOGUE["clocks"][method]]
    full = f"{model} Z" if "Z" in given else model
    need(full in CATALOGUE["models"], f"the model {model!r} is not understood")
    return list(CATALOGUE["models"][full])


class Element:
    """An environment (one formula) or an effect (four), with the numbers that the names in them stand for."""

    def __init__(self, table: Any, formulas: int, felt: "Element | None" = None) -> None:
        """``felt``: the environment whose parameters what is rendered may refer to."""
        need(isinstance(table, dict) and isinstance(table.get("model"), str), "an environment or effect has no model")
        model, given = table["model"], {key: x for key, x in table.items() if key not in ("model", "name")}
        own, self.lag = given.pop("parameters", {}), None
        signature, *self.texts = row(model, given)
        names = {re.split("[=?@]", x)[0]: x for x in signature.split()}
        needed = {key for key, x in names.items() if "?" not in x}
        fits = len(self.texts[:4]) == formulas and needed <= given.keys() <= names.keys() and isinstance(own, dict)
        need(fits and (not own or "=" in signature), f"the parameters of {model} are not understood")
        if "=" in signature:
            self.texts = [re.sub(r"\b[A-Z]\b", lambda x: str(given[x[0]]), text) for text in self.texts]
            self.numbers = {key: self.number(x, "", felt) for key, x in own.items()}
        else:
            self.numbers = {key: self.number(given.get(key, 0), key[0].lower(), felt) for key in names}
        lags = [(self.numbers[key], int(x[-1])) for key, x in names.items() if "@" in x]
        need(all(not x.pi and x.value >= 0 for x, _ in lags), "a delay is negative, or has pi in it")
        self.lag = sum((n * x.value for x, n in lags), Fraction(0)) if lags else None

    @staticmethod
    def number(given: Any, kind: str, felt: "Element | None") -> Number:
        """A parameter's value, or that of the environment's parameter that it refers to."""
        if isinstance(given, str) and felt and given.strip().startswith("environment."):
            name = re.sub(r"\[(\d+)\]$", r"_\1", given.strip().removeprefix("environment."))
            need(name in felt.numbers, f"{given[:60]!r} is no parameter of the environment")
            return felt.numbers[name]
        return quantity(given, kind)

    def at(self, point: Point) -> list[Ratio]:
        """The formulas' values; u/v is exp(-s lag)."""
        known = {name: x.at(point.pi) for name, x in self.numbers.items()}
        known |= {"s": point.s, "j": (Value(0, 1), ONE), "pi": Number(Fraction(1), 1).at(point.pi)}
        if self.lag is not None:
            u = point.delayed(self.lag)
            known |= {"u": (u, ONE), "v": (u.conjugate(), ONE)}

        def leaf(word: str) -> Ratio:
            need(word in known or word[0] in ".0123456789", f"the name {word!r} is not known")
            return known[word] if word in known else Number(Fraction(word)).at(point.pi)

        return [evaluated(x, leaf, combined) for x in self.texts]


def tables(x: Any) -> list[dict[str, Any]]:
    """A list of tables, of a file."""
    fits = isinstance(x, list) and len(x) <= 100 and all(isinstance(y, dict) for y in x)
    need(fits, "a list of at most 100 tables is none")
    return list(x)


def leave_free(table: Any, path: Any) -> None:
    """Put FREE for a number of a file: its path has keys, and places in lists from 0."""
    try:
        need(all(type(x) is str or (type(x) is int and x >= 0) for x in path), "a path is not understood")
        place = reduce(getitem, path[:-1], table)
        quantity(place[path[-1]])
        place[path[-1]] = FREE
    except (LookupError, TypeError):
        raise RefusedError("the scene has no such number") from None


KEYS = {"title", "source", "environment", "environments", "rendered", "effects", "evaluation", "hand", "hands"}


class Scene:
    """Band, thresholds and hands of a scene file, and its chain."""

    def __init__(self, data: bytes, name: str | None, free: list[str | int] | None = None) -> None:
        """``name``: which of several environments; ``free``: the keys, in the file, of a number that is left free."""
        try:
            table = tomllib.loads(data.decode("utf-8-sig"), parse_float=lambda text: quantity(text).value)
        except (ValueError, RecursionError) as error:
            raise UnreadableError(f"the scene is no TOML: {error}") from None
        need(table.keys() <= KEYS, f"keys of the scene are not understood: {', '.join(table.keys() - KEYS)}")
        if "environments" in table or name is not None:
            every = [x for x in tables(table.get("environments")) if x.get("name", x.get("model")) == name]
            fits = isinstance(name, str) and len(every) == 1 and table.keys().isdisjoint({"environment", "rendered"})
            need(fits, f"there is not one environment {name!r}")
            table["environment"] = {key: x for key, x in every[0].items() if key != "rendered"}
            table |= {key: x for key, x in every[0].items() if key == "rendered"}
        if free is not None:
            leave_free(table, free)
        self.felt = Element(table.get("environment"), 1)
        self.rendered = Element(table["rendered"], 1, self.felt) if "rendered" in table else self.felt
        self.effects, told = [Element(x, 4) for x in tables(table.get("effects", []))], table.get("evaluation", {})
        need(isinstance(told, dict) and told.keys() <= {"band", "jnd"}, "[evaluation] is not understood")
        band, jnd = told.get("band", [0, 15]), told.get("jnd", Fraction(1, 10))
        need(isinstance(band, list) and len(band) == 2, "the band is not a pair")
        self.band = [quantity(x, "o") for x in band]
        both = jnd if isinstance(jnd, dict) else {"real": jnd, "imag": jnd}
        need(both.keys() == {"real", "imag"}, "the threshold is not a number, nor one for each part")
        self.threshold = {part: quantity(x, "z") for part, x in both.items()}
        if free is not None:
            elements = [self.felt, self.rendered, *self.effects]
            own = [*self.threshold.values(), *(x for element in elements for x in element.numbers.values())]
            there = any("pi" in words_of(text) for element in elements for text in element.texts)
            need(not there and all(x is FREE or not x.pi for x in own) and FREE in own, "a parameter is free beside pi")
        self.hands = tables([table["hand"]] if "hand" in table else table.get("hands", []))

    def hand(self, name: str) -> dict[str, Any]:
        """Mass, damping and stiffness in the file."""
        found = [x for x in self.hands if x.get("name", "hand") == name]
        need(len(found) == 1 and "model" not in found[0], f"the scene has not one hand {name!r}")
        return {key: x for key, x in found[0].items() if key not in ("name", "source")}

    def at(self, point: Point) -> tuple[Ratio, Ratio]:
        """H_env and H_perc, each numerator and denominator; what is rendered with a clock, at the s of its method."""
        effects = [effect.at(point) for effect in self.effects]
        clocks = [s for effect in effects for s in effect[4:]]
        need(not clocks or (len(clocks) == 1 and effects[0][4:]), "a clock that is not the first effect")
        [felt] = self.felt.at(point)
        [(top, bottom)] = self.rendered.at(point._replace(s=clocks[0]) if clocks else point)
        for (a, x), (b, y), (c, z), (d, w), *_ in effects:
            above = a.times(y).times(top).plus(b.times(x).times(bottom))
            below = c.times(w).times(top).plus(d.times(z).times(bottom))
            top, bottom = above.times(z.times(w)), below.times(x.times(y))
        return felt, (top, bottom)
