"""What a scene file says, exactly, and rule 1: the functions of a proof are those of the scene.

The scene's formulas are not expanded. They are computed at integers in place of omega, pi, tangents
and powers, with bounds on the degrees, and so are the products of the proof. Two fractions are one
function if left bottom - right top vanishes at every point of a grid that is larger than its
degrees. Begin with ``link``; ``Element`` and ``SceneFile`` read the file.
"""

import re
import tomllib
from collections.abc import Callable, Iterator
from contextlib import suppress
from fractions import Fraction
from functools import cache, reduce
from itertools import chain, islice, product
from math import comb, factorial, prod
from operator import getitem
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from haptisym_check.polynomials import OmegaFactor
from haptisym_check.values import (
    ONE,
    ZERO,
    ChainPoint,
    GaussianValue,
    Ratio,
    RefusedError,
    UnreadableError,
    combined,
    degree,
    keyed,
    listed,
    need,
    number,
    whole,
)

# Formulas and quantities with units, as a scene file writes them: exact.

T = TypeVar("T")
NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3}(?![0-9]))?"
EXPONENT = r"[+-]?(?:[0-9]{1,2}(?:\.[0-9]{0,12})?|\.[0-9]{1,12})"
BROKEN = r"[+-]?[0-9]{1,2}\s*/\s*[1-9][0-9]?"
# A power is one word with its sign: its exponent is a number, never a formula.
POWER = rf"(?:\^|\*\*)\s*(?:\(\s*(?:{BROKEN}|{EXPONENT})\s*\)|{EXPONENT}(?![\w.]))"
WORD = re.compile(rf"{NUMBER}|[^\W\d]\w*|[°%]|{POWER}|[-+*/()]")
BINDS = {"+": 1, "-": 1, "*": 2, "/": 2}


@cache
def words_of(text: str) -> list[str]:
    """The numbers, names, signs and powers of a formula, in reverse: the next one is popped from
    the end."""
    words = WORD.findall(text) if len(text) <= 4000 else []
    # ``findall`` passes over what it does not know; a formula must be nothing but its words.
    whole = "".join("".join(words).split()) == "".join(text.split())
    need(words and len(words) <= 400 and whole, f"{text[:60]!r} is not understood")
    return words[::-1]


def evaluated(
    text: str, leaf: Callable[[str], T], combine: Callable[[str, T, T], T], *, spaced: bool = False
) -> T:
    """A formula's value, from what numbers, names and their broken powers are and how two combine;
    ``spaced``: N m is N*m."""
    words = [*words_of(text)]

    def value(least: int) -> T:
        """The value of the longest formula ahead whose signs bind more than ``least``."""
        word = words.pop() if words else ")"
        if word in BINDS:
            # A sign before a term is a factor 1 or -1, taken after powers: -s^2 is -(s^2).
            need(BINDS[word] == 1, f"{text[:60]!r} is not understood")
            found = combine("*", leaf(f"{word}1"), value(2))
        elif word == "(":
            found = value(0)
            need(words and words.pop() == ")", f"{text[:60]!r} is not understood")
        else:
            need(word[0] not in ")^*", f"{text[:60]!r} is not understood")
            found = leaf(word)
        if word not in BINDS and words and re.match(r"\^|\*\*", words[-1]):
            base, n = found, Fraction(re.sub("[^-0-9./]", "", words.pop()))
            # A whole power is a product. Any other one is a leaf by itself, for s or a unit only.
            found = leaf("1" if n.denominator == 1 else f"{word}^{n}")
            for _ in range(abs(int(n)) if n.denominator == 1 else 0):
                found = combine("*" if n > 0 else "/", found, base)
        while words and words[-1] != ")" and BINDS.get(words[-1], BINDS["*"]) > least:
            sign = words[-1] if words[-1] in BINDS else "*"
            # Two words without a sign between are a product of units, as in N m. In a formula, or
            # before a number, that is refused.
            unsaid = words[-1] != sign and (
                not spaced or (words[-1] != "1" and words[-1][0] in ".0123456789")
            )
            need(not unsaid, f"{text[:60]!r} is not understood")
            found = combine(sign, found, value(BINDS[words.pop() if words[-1] == sign else sign]))
        return found

    result = value(0)
    need(not words, f"{text[:60]!r} is not understood")
    return result


class DimensionedNumber(NamedTuple):
    """value * pi^pi, and its dimension, powers of kg, m and s; None without a unit."""

    value: Fraction
    pi: int = 0
    dimension: list[Any] | None = None

    def at(self, pi: int) -> Ratio:
        """With a whole number in place of pi."""
        up, down = max(self.pi, 0), max(-self.pi, 0)
        top = GaussianValue(self.value.numerator * pi**up, 0, degree(1, up)) if self.value else ZERO
        return top, GaussianValue(self.value.denominator * pi**down, 0, degree(1, down))


FREE = DimensionedNumber(Fraction(1), 1)  # a parameter that is left free takes the place of pi
CATALOGUE = tomllib.loads((Path(__file__).parent / "catalogue.toml").read_text(encoding="utf-8"))
SPELLED: dict[int, str] = {
    ord(x): y for x, y in zip("·×⋅²³", ("*", "*", "*", "^2", "^3"), strict=True)
}


def unit(word: str) -> DimensionedNumber:
    """The value and dimension of a number, or of a unit by its name, perhaps with a prefix."""
    if word[0] in "+-.0123456789" and "^" not in word:
        return DimensionedNumber(Fraction(word))
    name, _, power = word.partition("^")
    # The whole name first: "min" is a minute and no milli-inch, "m" a metre and no prefix.
    prefix, base = ("", name) if name in CATALOGUE["units"] else (name[:1], name[1:])
    factor, pi, dimension, prefixed = CATALOGUE["units"].get(base, ["1", 0, [], ""])
    fits = dimension and (not prefix or (prefix in CATALOGUE["prefixes"] and prefixed))
    need(fits, f"the unit {word!r} is not understood")
    value = Fraction(factor) * Fraction(10) ** CATALOGUE["prefixes"].get(prefix, 0)
    # A power that is not whole: only of units whose factor is 1, as a root of 1000 or of pi would
    # not be exact.
    need(not power or (value == 1 and not pi), f"the power {word!r} is not rational")
    return DimensionedNumber(value, pi, [Fraction(power or 1) * n for n in dimension])


def units(sign: str, x: DimensionedNumber, y: DimensionedNumber) -> DimensionedNumber:
    """The product or the quotient of two quantities, with their dimensions."""
    need(sign in "*/", "a quantity is a product of powers")
    n = 1 if sign == "*" else -1
    need(n > 0 or y.value, "a division by zero")
    value = x.value * y.value**n
    need(
        value.numerator.bit_length() + value.denominator.bit_length() < 10**5,
        "a number is too large",
    )
    both = [
        a + n * b for a, b in zip(x.dimension or [0, 0, 0], y.dimension or [0, 0, 0], strict=True)
    ]
    return DimensionedNumber(
        value, x.pi + n * y.pi, None if x.dimension is y.dimension is None else both
    )


def quantity(given: Any, kind: str = "") -> DimensionedNumber:
    """A number with or without a unit, exactly; of a range the nominal value. ``kind``: a key of
    the dimensions."""
    if isinstance(given, list):
        need(
            2 <= len(given) <= 3, "a range has two ends, and perhaps its nominal value between them"
        )
        low, *between, high = (quantity(x, kind) for x in given)
        # Ends with different powers of pi have no middle that is a rational times one of them.
        need(low[1:] == high[1:], "the ends of a range have different units")
        return between[0] if between else low._replace(value=(low.value + high.value) / 2)
    if isinstance(given, DimensionedNumber):
        return given
    if isinstance(given, int | Fraction) and not isinstance(given, bool):
        return DimensionedNumber(Fraction(given))
    need(isinstance(given, str) and len(given) < 500, "a value is neither a number nor a text")
    # What follows +- is an uncertainty: claims are about the nominal value.
    text, *deviation = re.split(r"\+/?-|±", given)
    allowed = CATALOGUE["dimensions"][kind] if kind else []
    plain = text.translate(SPELLED)
    try:
        nominal = evaluated(plain, unit, units, spaced=True)
        need(
            len(deviation) < 2 and (not allowed or nominal.dimension in (None, *allowed)),
            f"{given[:60]!r} has the wrong dimension",
        )
    except RefusedError:
        # Names of units that are run together mean what has the dimension that is wanted, if that
        # is one thing.
        readings: list[DimensionedNumber] = []
        for spelt in run_together(plain):
            with suppress(RefusedError):
                nominal = evaluated(spelt, unit, units, spaced=True)
                if nominal.dimension in allowed and nominal not in readings:
                    readings.append(nominal)
        if len(readings) != 1 or len(deviation) > 1:
            raise
        [nominal] = readings
    return nominal


def run_together(text: str) -> Iterator[str]:
    """A quantity as it is written, with products for what engineers write: Nms, N-m, N.m, kg.m2;
    what stands behind a stroke is below it."""
    number = re.match(rf"[\s+-]*{NUMBER}(?:\s*/\s*\d+)?", text)
    size = number[0] if number else ""
    rest = re.sub(r"/([^*/()\s]+)", r"/(\1)", text[len(size) :])
    rest = re.sub(r"(?<=\w)[-.](?=[^\W\d_])", "*", rest)
    rest = re.sub(r"(?<=[^\W\d_])(-?\d)", r"^(\1)", rest)
    names = list(dict.fromkeys(re.findall(r"[^\W\d_]+", rest)))
    for chosen in islice(product(*map(apart, names)), 200):
        parts = dict(zip(names, chosen, strict=True))
        yield size + "".join(str(parts.get(x, x)) for x in re.split(r"([^\W\d_]+)", rest))


def apart(word: str) -> list[str]:
    """A word, and the products of two or more different units that it is if it has eight letters at
    most."""
    ways = [word]
    for i in range(1, len(word) if len(word) <= 8 else 0):
        with suppress(RefusedError):
            unit(word[:i])
            ways += [f"{word[:i]}*{x}" for x in apart(word[i:]) if word[:i] not in x.split("*")]
    return ways


# What a scene file says: exact numbers, and the chain of its dynamics in Gaussian integers wherever
# it is asked for.

# A dynamics times s to a power: in a product powers are added, as s^a s^b = s^(a + b). Two powers
# that are not whole can so make one that is, and need no order of the proof.
Powered = tuple[Ratio, Fraction]


def row(model: str, given: dict[str, Any]) -> list[str]:
    """The row of the catalogue for a model with these parameters: its signature, then its formulas;
    lists among the parameters are taken apart."""
    if model == "prony":
        k, b = given.pop("k", None), given.pop("b", None)
        need(
            isinstance(k, list) and isinstance(b, list) and 0 < len(k) == len(b) <= 20,
            "k and b must be lists alike",
        )
        given.update(
            {f"{key}_{i}": x for key, xs in (("k", k), ("b", b)) for i, x in enumerate(xs, 1)}
        )
        own = "".join(f" + k_{i}*b_{i}*s/(k_{i} + b_{i}*s)" for i in range(1, len(k) + 1))
        return [" ".join(["k0", *set(re.findall(r"[kb]_\d+", own))]), f"k0{own}"]
    if model == "pade-delay":
        n = given.pop("order", 0)
        need(type(n) is int and 1 <= n <= 10, "the order must be a whole number from 1 to 10")
        # Pade's quotient p(-s tau)/p(s tau) of order n; the common factor of all its coefficients,
        # which cancels, is left out, so that they are integers.
        weights = [comb(n, i) * factorial(2 * n - i) for i in range(n + 1)]
        back, forth = (
            " + ".join(f"{c}*({x}s*tau)^{i}" for i, c in enumerate(weights)) for x in ("-", "")
        )
        return ["tau", back, "0", "0", forth]
    if model == "sampled-loop":
        method, n = given.pop("method", None), given.pop("delay", 0)
        need(
            type(n) is int and 0 <= n <= 20,
            "the delay must be a whole number of samples, from 0 to 20",
        )
        # u/v = exp(-s T), so v/u is z. Without a method what is rendered is in z itself.
        clock = "v/u" if method is None else CATALOGUE["clocks"].get(str(method))
        need(clock is not None, "the method of a clock is not understood")
        return ["T@1", f"u^{n}*(v - u)", "0", "0", f"s*T*v^{n + 1}", str(clock)]
    # Some models have a second form, for other parameters: with a dynamics Z, or with a delay tau.
    variants = (f"{model} {x}" for x in ("Z", "tau") if x in given)
    full = next((x for x in variants if x in CATALOGUE["models"]), model)
    need(full in CATALOGUE["models"], f"the model {model!r} is not understood")
    return list(CATALOGUE["models"][full])


class Element:
    """An environment (one formula) or an effect (four), with the numbers that the names in them
    stand for."""

    def __init__(self, table: Any, formulas: int, felt: "Element | None" = None) -> None:
        """``felt``: the environment whose parameters what is rendered may refer to."""
        need(
            isinstance(table, dict) and isinstance(table.get("model"), str),
            "an environment or effect has no model",
        )
        model = table["model"]
        given = {key: x for key, x in table.items() if key not in ("model", "name")}
        own, self.lag = given.pop("parameters", {}), None
        self.in_z = model == "difference-equation"
        signature, *self.texts = row(model, given)
        # A mark in the signature: "?" a parameter that may be left out, "=" a formula of the scene,
        # "@n" a delay whose n-fold is the lag, "^" the order of a power.
        names = {re.split("[=?@^]", x)[0]: x for x in signature.split()}
        needed = {key for key, x in names.items() if "?" not in x}
        fits = (
            len(self.texts[:4]) == formulas
            and needed <= given.keys() <= names.keys()
            and isinstance(own, dict)
        )
        need(
            fits and (not own or "=" in signature), f"the parameters of {model} are not understood"
        )
        if "=" in signature:
            # The scene's formulas take the places of the capitals in those of the model.
            self.texts = [
                re.sub(r"\b[A-Z]\b", lambda x: str(given[x[0]]), text) for text in self.texts
            ]
            lag = {key for key, x in names.items() if "@" in x and key in given}
            formulas_given = [x for key, x in given.items() if key not in lag]
            words = {*own, *re.findall(r"\w+", str(formulas_given))}
            # u and v are what the model calls the parts of exp(-s lag).
            need(not lag or not {"u", "v", *lag} & words, "a name stands for two numbers")
            self.numbers = {key: self.number(x, "", felt) for key, x in own.items()}
            self.numbers |= {key: self.number(given[key], "t", felt) for key in lag}
            if self.in_z:
                # Its z is the variable at which the element is computed, as s is elsewhere;
                # ``SceneFile.at`` puts the clock's value there.
                need("s" not in words and "z" not in own, "no difference equation in z")
                self.texts = [re.sub(r"\bz\b", "s", text) for text in self.texts]
        else:
            kinds = {
                key: key if key in CATALOGUE["dimensions"] else key[0].lower() for key in names
            }
            self.numbers = {
                key: self.number(given.get(key, 0), kind, felt) for key, kind in kinds.items()
            }
        marked = [(key, x) for key, x in names.items() if "@" in x and key in self.numbers]
        lags = [(self.numbers[key], int(x[-1])) for key, x in marked]
        # A delay with pi is a multiple of none of the proof's, which are rational.
        need(
            all(not x.pi and x.value >= 0 for x, _ in lags), "a delay is negative, or has pi in it"
        )
        self.lag = sum((n * x.value for x, n in lags), Fraction(0)) if lags else None
        order = next((self.numbers[key] for key, x in names.items() if "^" in x), None)
        need(
            not order or (not order.pi and 0 < order.value < 1),
            "an order is not a number between 0 and 1",
        )
        self.order = order and order.value

    @staticmethod
    def number(given: Any, kind: str, felt: "Element | None") -> DimensionedNumber:
        """A parameter's value, or that of the environment's parameter that it refers to."""
        if isinstance(given, str) and felt and given.strip().startswith("environment."):
            name = re.sub(r"\[(\d+)\]$", r"_\1", given.strip().removeprefix("environment."))
            need(name in felt.numbers, f"{given[:60]!r} is no parameter of the environment")
            return felt.numbers[name]
        return quantity(given, kind)

    def at(self, point: ChainPoint) -> list[Ratio]:
        """The formulas' values; u/v is exp(-s lag), z is s^alpha."""
        known = {name: x.at(point.pi) for name, x in self.numbers.items()}
        known |= {
            "s": point.s,
            "j": (GaussianValue(0, 1), ONE),
            "pi": DimensionedNumber(Fraction(1), 1).at(point.pi),
        }
        if self.lag is not None:
            u = point.delayed(self.lag)
            known |= {"u": (u, ONE), "v": (u.conjugate(), ONE)}
        if self.order is not None:
            known["z"] = point.raised(self.order)

        def leaf(word: str) -> Powered:
            if word.startswith("s^"):
                return (ONE, ONE), Fraction(word[2:])
            if word in known:
                return known[word], Fraction(0)
            is_number = "^" not in word and word[0] in "+-.0123456789"
            need(is_number, f"the name {word!r} is not known")
            return DimensionedNumber(Fraction(word)).at(point.pi), Fraction(0)

        def shifted(x: Ratio, n: Fraction) -> Ratio:
            return combined("*", x, point.raised(n)) if n else x

        def both(sign: str, x: Powered, y: Powered) -> Powered:
            (a, m), (b, n) = x, y
            if sign in "*/":
                return combined(sign, a, b), m + n if sign == "*" else m - n
            # Multiples of one power, without s: the power stays, and may yet meet another one.
            alike = m == n and all(max(v.degrees) <= 0 for v in (*a, *b))
            # The polynomial 0, whose degree is below all others, leaves the other term its power.
            nothing = [top.degrees[0] < 0 for top, _ in (a, b)]
            if alike or any(nothing):
                return combined(sign, a, b), n if nothing[0] else m
            return combined(sign, shifted(a, m), shifted(b, n)), Fraction(0)

        return [shifted(*evaluated(x, leaf, both)) for x in self.texts]


def tables(x: Any) -> list[dict[str, Any]]:
    """A list of tables of a file, at most 100; refused if it is none."""
    need(
        isinstance(x, list) and len(x) <= 100 and {*map(type, x)} <= {dict},
        "a list of at most 100 tables is none",
    )
    return list(x)


def leave_free(table: Any, path: Any) -> None:
    """Put FREE for a number of a file: its path has keys, and places in lists from 0."""
    try:
        need(
            all(type(x) is str or (type(x) is int and x >= 0) for x in path),
            "a path is not understood",
        )
        place = reduce(getitem, path[:-1], table)
        quantity(place[path[-1]])
        place[path[-1]] = FREE
    except (LookupError, TypeError):
        raise RefusedError("the scene has no such number") from None


def carried(table: Any) -> list[dict[str, Any]]:
    """What a file's device puts at the hand: a shunt of its mass and damping, and its friction at
    an amplitude."""
    fits = isinstance(table, dict) and table.keys() <= {"like", "m", "b", "friction", "amplitude"}
    need(fits, "[device] is not understood")
    need(str(table.get("like")) in CATALOGUE["devices"], "the device is not known")
    own = {**CATALOGUE["devices"][str(table["like"])], **table}
    shunt = {key: own[key] for key in ("m", "b") if key in own}
    need(
        shunt and ("friction" in own or "amplitude" not in own), "a number of the device is missing"
    )
    rubbing = {
        "model": "coulomb-friction",
        "force": own.get("friction"),
        "amplitude": own.get("amplitude"),
    }
    return [{"model": "shunt", **shunt}, *([rubbing] if "amplitude" in own else [])]


KEYS = {
    "title",
    "source",
    "environment",
    "environments",
    "rendered",
    "effects",
    "device",
    "evaluation",
    "hand",
    "hands",
}

MOST_STEPS = 10_000_000
"""Limit of the work for dotted keys: ``tomllib`` takes steps as many as the square of the dots."""


class SceneFile:
    """Band, thresholds and hands of a scene file, and its chain."""

    def __init__(self, data: bytes, name: str | None, free: list[str | int] | None = None) -> None:
        """``name``: which of several environments; ``free``: the keys, in the file, of a number
        that is left free."""
        if sum(line.count(b".") ** 2 for line in data.splitlines()) > MOST_STEPS:
            raise UnreadableError(
                "the scene has too many dots in a line: keys of so many parts are not read"
            )
        try:
            # 0.1 is 1/10: no float is ever made of a number of the file.
            table = tomllib.loads(
                data.decode("utf-8-sig"), parse_float=lambda x: quantity(x.replace("_", "")).value
            )
        except (ValueError, RecursionError) as error:
            raise UnreadableError(f"the scene is no TOML: {error}") from None
        need(
            table.keys() <= KEYS,
            f"keys of the scene are not understood: {sorted(table.keys() - KEYS)}",
        )
        if "environments" in table or name is not None:
            rows = tables(table.get("environments"))
            every = [x for x in rows if x.get("name", x.get("model")) == name]
            fits = (
                isinstance(name, str)
                and len(every) == 1
                and table.keys().isdisjoint({"environment", "rendered"})
            )
            need(fits, f"there is not one environment {name!r}")
            table["environment"] = {key: x for key, x in every[0].items() if key != "rendered"}
            table |= {key: x for key, x in every[0].items() if key == "rendered"}
        if free is not None:
            leave_free(table, free)
        self.felt = Element(table.get("environment"), 1)
        self.rendered = (
            Element(table["rendered"], 1, self.felt) if "rendered" in table else self.felt
        )
        worn = carried(table["device"]) if "device" in table else []
        # The device is nearest to the hand, so its effects come last.
        self.effects = [Element(x, 4) for x in [*tables(table.get("effects", [])), *worn]]
        told = table.get("evaluation", {})
        elements = [self.felt, self.rendered, *self.effects]
        fits = self.rendered.in_z == any(x.texts[4:] == ["v/u"] for x in self.effects)
        need(fits and not self.felt.in_z, "a clock and what it renders do not fit")
        self.length = sum(len(text) for element in elements for text in element.texts)
        need(
            isinstance(told, dict) and told.keys() <= {"band", "jnd"},
            "[evaluation] is not understood",
        )
        band, jnd = told.get("band", [0, 15]), told.get("jnd", Fraction(1, 10))
        need(isinstance(band, list) and len(band) == 2, "the band is not a pair")
        self.band = [quantity(x, "o") for x in band]
        both = jnd if isinstance(jnd, dict) else {"real": jnd, "imag": jnd}
        need(
            both.keys() == {"real", "imag"}, "the threshold is not a number, nor one for each part"
        )
        self.threshold = {part: quantity(x, "z") for part, x in both.items()}
        if free is not None:
            # The parameter takes the place of pi in every polynomial, so pi itself may stand
            # nowhere but in the band, which is not part of the functions.
            values = list(self.threshold.values())
            for element in elements:
                values += element.numbers.values()
            there = any("pi" in words_of(text) for element in elements for text in element.texts)
            need(
                not there and all(x is FREE or not x.pi for x in values) and FREE in values,
                "a parameter is free beside pi",
            )
        self.hands = tables([table["hand"]] if "hand" in table else table.get("hands", []))

    def hand(self, name: str) -> dict[str, Any]:
        """Mass, damping and stiffness in the file."""
        named = [x for x in self.hands if x.get("name", "hand") == name]
        need(len(named) == 1 and "model" not in named[0], f"the scene has not one hand {name!r}")
        numbers = {key: x for key, x in named[0].items() if key not in ("name", "source", "lever")}
        if "lever" not in named[0]:
            return numbers
        # On a lever each number is its square times as large, about the axis.
        arm = quantity(named[0]["lever"])
        need(arm.value > 0 and arm.dimension in (None, [0, 1, 0]), "a lever is a length")
        square = units("*", arm, arm)
        return {key: units("*", quantity(x, key), square) for key, x in numbers.items()}

    def at(self, point: ChainPoint) -> tuple[Ratio, Ratio]:
        """H_env and H_perc, each numerator and denominator; what is rendered with a clock, at the s
        of its method."""
        effects = [effect.at(point) for effect in self.effects]
        clocks = [s for effect in effects for s in effect[4:]]
        need(
            not clocks or (len(clocks) == 1 and effects[0][4:]),
            "a clock that is not the first effect",
        )
        [(top, bottom)] = self.rendered.at(
            point._replace(s=clocks[0], orders=()) if clocks else point
        )
        # Each effect is a matrix [[a/x, b/y], [c/z, d/w]] and makes of a dynamics H
        # (a/x H + b/y)/(c/z H + d/w); both sides are multiplied by x y z w.
        for (a, x), (b, y), (c, z), (d, w), *_ in effects:
            above = a.times(y).times(top).plus(b.times(x).times(bottom))
            below = c.times(w).times(top).plus(d.times(z).times(bottom))
            top, bottom = above.times(z.times(w)), below.times(x.times(y))
        return self.felt.at(point)[0], (top, bottom)


# Rule 1: the functions of a proof are those of the scene.

PARTS = "real", "imag"
Sides = tuple[GaussianValue, GaussianValue, GaussianValue, GaussianValue]
Numbers = tuple[Fraction, ...]


class FactoredNumber:
    """number * product of factor^exponent: a product of the format."""

    def __init__(self, x: Any, factors: list[OmegaFactor]) -> None:
        value, powers = keyed(x, "number", "powers")
        rows = [listed(row, 2, 2) for row in listed(powers, 500)]
        self.number = number(value)
        self.powers = {whole(i, 0, len(factors) - 1): whole(n, -100, 100) for i, n in rows}
        need(len(self.powers) == len(rows), "a factor stands twice in a product")
        need(self.number or not rows, "a function that is zero everywhere has no factors")
        self.size = sum(abs(n) * factors[i].size for i, n in self.powers.items())
        degrees = ([n * k for k in factors[i].waves] for i, n in self.powers.items())
        waves = [sum(column) for column in zip(*degrees, strict=True)]
        # A factor of degree n in sine and cosine is cos^n times a polynomial in the tangent t. An
        # odd power of the cosine is no rational function of t; an even one is, by
        # cos^2 = 1/(1 + t^2).
        need(not any(n % 2 for n in waves), "a product changes its sign in a turn")
        self.circles = [-n // 2 for n in waves]

    def at(self, factors: list[GaussianValue], circles: list[GaussianValue]) -> Ratio:
        """Numerator and denominator, with values of the factors and of 1 + t^2 for each tangent
        t."""
        sides = [GaussianValue(self.number.numerator), GaussianValue(self.number.denominator)]
        powers = [(factors[i], n) for i, n in self.powers.items()]
        for x, n in [*powers, *zip(circles, self.circles, strict=False)]:
            sides[n < 0] = sides[n < 0].times(x.power(abs(n)))
        return sides[0], sides[1]


def functions(
    scene: SceneFile, delays: Numbers, orders: Numbers, x: GaussianValue, pi: int, *others: Any
) -> dict[str, Ratio]:
    """The ten functions, numerator and denominator, at a frequency."""
    h, g = scene.at(ChainPoint((x.times(GaussianValue(0, 1)), ONE), pi, delays, orders, others))
    pairs = {
        "environment": h,
        "perceived": g,
        "difference": combined("-", g, h),
        "sum": combined("+", g, h),
    }
    ratios: dict[str, Ratio] = {}
    for name, (u, v) in pairs.items():
        turned = u.times(v.conjugate())  # u/v = u conj(v)/|v|^2
        for part, size in zip(PARTS, turned[:2], strict=True):
            ratios[f"{name}.{part}"] = turned._replace(re=size, im=0), v.times(v.conjugate())
    root = h[0].times(h[1]).times(g[1]).times(g[1])  # H = N/D, G = P/Q
    for part in PARTS:  # (Re (G - H))^2/|H|^2 = (Re ((P D - Q N) conj(D Q)))^2/(|N|^2 |D|^2 |Q|^4)
        y, limit = ratios[f"difference.{part}"][0], scene.threshold[part].at(pi)
        ratio = y.times(y), root.times(root.conjugate())
        ratios[f"excess.{part}"] = combined("-", ratio, combined("*", limit, limit))
    return ratios


Values = Callable[..., dict[str, Ratio]]
Counts = tuple[int, int]


class FunctionGrid:
    """Functions of a scene, and as told, at whole numbers in place of omega (or s), pi, tangents
    and powers."""

    def __init__(
        self,
        told: dict[str, FactoredNumber],
        factors: list[OmegaFactor],
        scene: Values,
        delays: int,
        orders: int,
    ) -> None:
        self.told, self.factors, self.scene = told, factors, scene
        self.delays, self.orders = delays, orders
        # Any one point shows the degrees: they do not depend on the values.
        self.start = self.sides(0, 1, *[0] * delays, *[(0, 0)] * orders)

    def sides(self, x: int, pi: int, *others: Any) -> dict[str, Sides]:
        """Numerator and denominator of each function in the scene, and as told."""
        tangents, powers = others[: self.delays], others[self.delays :]
        circles = [GaussianValue(1 + t * t, 0, degree(2 + i, 2)) for i, t in enumerate(tangents)]
        variables = [*tangents, *chain(*powers)]
        values = [factor.at(x, pi, variables) for factor in self.factors]
        omega = GaussianValue(x, 0, degree(0))
        functions = self.scene(omega, pi, *others)
        return {
            name: (*functions[name], *told.at(values, circles)) for name, told in self.told.items()
        }

    def elsewhere(self, k: int) -> dict[str, Sides]:
        """The same at a place that differs from others in all numbers."""
        powers = ((k + 3 + i, k + 4) for i in range(self.orders))
        return self.sides(k, k + 1, *range(k + 2, k + 2 + self.delays), *powers)

    def zero(
        self, names: set[str], rests: Callable[[str, Sides], list[GaussianValue]], cost: int
    ) -> set[str]:
        """The names for which all polynomials of ``rests`` vanish on a grid that is larger than
        their degrees, so that they are zero; refused where left bottom is not right top on it."""
        rows = (x.degrees for name in names for x in rests(name, self.start[name]))
        # One point more in each variable than its degree: a polynomial that vanishes on all of them
        # is zero. For Re and Im of a power, whose degrees have one bound together, a triangle of
        # points does, about half as many as a square.
        bounds = [max(0, *column) + 1 for column in zip(*rows, strict=True)]
        n, m, *size = bounds[: 2 + self.delays + self.orders]
        tangents, powers = size[: self.delays], size[self.delays :]
        corners = [k * (k + 1) // 2 for k in powers]
        need(
            n <= 3000 and n * m * prod(tangents + corners) * cost <= 3 * 10**7,
            "the degrees are too high",
        )
        triangles = ([(i, k) for i in range(most) for k in range(most - i)] for most in powers)
        axes = (range(n), range(1, m + 1), *map(range, tangents), *triangles)
        for at in product(*map(list[Any], axes)):
            sides = self.sides(*at) if names else {}
            wrong = [name for name in names if across(name, sides[name])[0][:2] != (0, 0)]
            need(not wrong, f"{', '.join(sorted(wrong))}: not that of the scene")
            names = {
                name for name in names if all(x[:2] == (0, 0) for x in rests(name, sides[name]))
            }
        return names


def across(_: str, x: Sides) -> list[GaussianValue]:
    """left bottom - right top: zero where both fractions are one function."""
    return [x[2].times(x[1]).plus(x[3].times(x[0]), -1)]


def link(
    x: Any,
    names: list[str],
    factors: list[OmegaFactor],
    scene: Values,
    length: int,
    waves: Counts = (0, 0),
    share: int = 1,
) -> dict[str, FactoredNumber]:
    """Products, proven to be functions of a scene, which it gives for omega (or s), pi, tangents
    and powers: on a grid.

    ``length``: of the scene's formulas. ``waves``: how many delays and how many orders there are.
    ``share``: one of how many such questions it is, which together may take so long as one.
    """
    told = {
        name: FactoredNumber(y, factors) for name, y in zip(names, keyed(x, *names), strict=True)
    }
    cost = share * (
        sum(x.size for x in factors) + sum(x.size for x in told.values()) + 5 * length + 100
    )
    grid = FunctionGrid(told, factors, scene, *waves)
    fixed: dict[str, tuple[GaussianValue, GaussianValue]] = {}
    # Across, 0 bottom = right 0 would fit anything. One point where neither denominator is zero
    # shows that neither is the polynomial 0.
    for k in range(17, 25):
        other = grid.elsewhere(k) if len(fixed) < len(told) else {}
        fixed |= {name: (x[3], x[1]) for name, x in other.items() if x[3].re and x[1][:2] != (0, 0)}
    need(len(fixed) == len(told), "a function is nowhere defined")

    def multiples(name: str, x: Sides) -> list[GaussianValue]:
        """What vanishes where the scene's numerator and denominator are those told, times one
        number."""
        u, v = (y._replace(degrees=degree(0, 0)) for y in fixed[name])
        return [x[i].times(u).plus(x[i + 2].times(v), -1) for i in range(2)]

    # If numerators and denominators agree up to one number, polynomials of about half the degree
    # are to be tested, on a smaller grid. Where something was cancelled the larger one is needed.
    left = set(names) - grid.zero(set(names), multiples, cost)
    need(not left or grid.zero(left, across, cost) == left, "a function is not that of the scene")
    return told
