"""What a scene file says, exactly, and rule 1: the functions of a proof are those of the scene.

The scene's formulas are not expanded. They are computed at integers in place of omega, pi, tangents
and powers, with bounds on the degrees, and so are the products of the proof. Two fractions are one
function if left bottom - right top vanishes at every point of a grid that is larger than its
degrees.

The *chain* of a scene is its dynamics and effects, from what is rendered to the hand; a ``Ratio``
is a numerator and a denominator. Begin with ``link``; ``Element`` and ``SceneFile`` read the file.
"""

import re
import tomllib
from collections.abc import Callable, Iterable, Iterator
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
    read = "".join(words)
    whole = "".join(read.split()) == "".join(text.split())
    few = len(words) <= 400
    need(words and few and whole, f"{text[:60]!r} is not understood")
    return words[::-1]


def evaluated(
    text: str, leaf: Callable[[str], T], combine: Callable[[str, T, T], T], *, spaced: bool = False
) -> T:
    """A formula's value, from what numbers, names and their broken powers are and how two combine;
    ``spaced``: N m is N*m."""
    words = [*words_of(text)]
    not_understood = f"{text[:60]!r} is not understood"

    def value(least: int) -> T:
        """The value of the longest formula ahead whose signs bind more than ``least``."""
        word = words.pop() if words else ")"
        if word in BINDS:
            # A sign before a term is a factor 1 or -1, taken after powers: -s^2 is -(s^2).
            need(BINDS[word] == 1, not_understood)
            found = combine("*", leaf(f"{word}1"), value(2))
        elif word == "(":
            found = value(0)
            need(words and words.pop() == ")", not_understood)
        else:
            need(word[0] not in ")^*", not_understood)
            found = leaf(word)
        if word not in BINDS and words and re.match(r"\^|\*\*", words[-1]):
            exponent = re.sub("[^-0-9./]", "", words.pop())
            n = Fraction(exponent)
            if n.denominator == 1:
                base = found
                found = leaf("1")
                for _ in range(abs(int(n))):
                    found = combine("*" if n > 0 else "/", found, base)
            else:
                # A power that is not whole is a leaf by itself, for s or a unit only.
                found = leaf(f"{word}^{n}")
        while words and words[-1] != ")":
            ahead = words[-1]
            sign = ahead if ahead in BINDS else "*"
            if BINDS[sign] <= least:
                break
            if ahead == sign:
                words.pop()
            else:
                # Two words without a sign between are a product of units, as in N m. In a formula,
                # or before a number, that is refused.
                is_number = ahead != "1" and ahead[0] in ".0123456789"
                need(spaced and not is_number, not_understood)
            found = combine(sign, found, value(BINDS[sign]))
        return found

    result = value(0)
    need(not words, not_understood)
    return result


class DimensionedNumber(NamedTuple):
    """value * pi^pi, and its dimension, powers of kg, m and s; None without a unit."""

    value: Fraction
    pi: int = 0
    dimension: list[Any] | None = None

    def at(self, pi: int) -> Ratio:
        """With a whole number in place of pi."""
        up = max(self.pi, 0)
        down = max(-self.pi, 0)
        top = ZERO
        if self.value:
            top = GaussianValue(self.value.numerator * pi**up, 0, degree(1, up))
        bottom = GaussianValue(self.value.denominator * pi**down, 0, degree(1, down))
        return top, bottom


FREE = DimensionedNumber(Fraction(1), 1)  # a parameter that is left free takes the place of pi
CATALOGUE_FILE = Path(__file__).parent / "catalogue.toml"
CATALOGUE = tomllib.loads(CATALOGUE_FILE.read_text(encoding="utf-8"))
SPELLED = str.maketrans({"·": "*", "×": "*", "⋅": "*", "²": "^2", "³": "^3"})


def unit(word: str) -> DimensionedNumber:
    """The value and dimension of a number, or of a unit by its name, perhaps with a prefix."""
    if word[0] in "+-.0123456789" and "^" not in word:
        return DimensionedNumber(Fraction(word))
    known, prefixes = CATALOGUE["units"], CATALOGUE["prefixes"]
    name, _, power = word.partition("^")
    # The whole name first: "min" is a minute and no milli-inch, "m" a metre and no prefix.
    prefix, base = ("", name) if name in known else (name[:1], name[1:])
    factor, pi, dimension, prefixed = known.get(base, ["1", 0, [], ""])
    prefix_fits = not prefix or (prefix in prefixes and prefixed)
    need(dimension and prefix_fits, f"the unit {word!r} is not understood")
    ten = Fraction(10)
    value = Fraction(factor) * ten ** prefixes.get(prefix, 0)
    # A power that is not whole: only of units whose factor is 1, as a root of 1000 or of pi would
    # not be exact.
    is_one = value == 1 and not pi
    need(not power or is_one, f"the power {word!r} is not rational")
    n = Fraction(power or 1)
    return DimensionedNumber(value, pi, [n * x for x in dimension])


def units(sign: str, x: DimensionedNumber, y: DimensionedNumber) -> DimensionedNumber:
    """The product or the quotient of two quantities, with their dimensions."""
    need(sign in "*/", "a quantity is a product of powers")
    n = 1 if sign == "*" else -1
    need(n > 0 or y.value, "a division by zero")
    value = x.value * y.value**n
    bits = value.numerator.bit_length() + value.denominator.bit_length()
    need(bits < 10**5, "a number is too large")
    pi = x.pi + n * y.pi
    if x.dimension is None and y.dimension is None:
        return DimensionedNumber(value, pi)
    one = [0, 0, 0]  # kg^0 m^0 s^0
    pairs = zip(x.dimension or one, y.dimension or one, strict=True)
    return DimensionedNumber(value, pi, [a + n * b for a, b in pairs])


def quantity(given: Any, kind: str = "") -> DimensionedNumber:
    """A number with or without a unit, exactly; of a range the nominal value. ``kind``: a key of
    the dimensions."""
    if isinstance(given, list):
        fits = 2 <= len(given) <= 3
        need(fits, "a range has two ends, and perhaps its nominal value between them")
        low, *between, high = (quantity(x, kind) for x in given)
        # Ends with different powers of pi have no middle that is a rational times one of them.
        need(low[1:] == high[1:], "the ends of a range have different units")
        middle = (low.value + high.value) / 2
        return between[0] if between else low._replace(value=middle)
    if isinstance(given, DimensionedNumber):
        return given
    if isinstance(given, int | Fraction) and not isinstance(given, bool):
        return DimensionedNumber(Fraction(given))
    is_text = isinstance(given, str) and len(given) < 500
    need(is_text, "a value is neither a number nor a text")
    # What follows +- is an uncertainty: claims are about the nominal value.
    text, *deviation = re.split(r"\+/?-|±", given)
    allowed = CATALOGUE["dimensions"][kind] if kind else []
    plain = text.translate(SPELLED)
    try:
        nominal = evaluated(plain, unit, units, spaced=True)
        fits = not allowed or nominal.dimension in (None, *allowed)
        need(len(deviation) < 2 and fits, f"{given[:60]!r} has the wrong dimension")
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
        k = given.pop("k", None)
        b = given.pop("b", None)
        are_lists = isinstance(k, list) and isinstance(b, list)
        need(are_lists and 0 < len(k) == len(b) <= 20, "k and b must be lists alike")
        formula = names = "k0"
        for i, (stiffness, damping) in enumerate(zip(k, b, strict=True), 1):
            given[f"k_{i}"] = stiffness
            given[f"b_{i}"] = damping
            names += f" k_{i} b_{i}"
            formula += f" + k_{i}*b_{i}*s/(k_{i} + b_{i}*s)"
        return [names, formula]
    if model == "pade-delay":
        n = given.pop("order", 0)
        fits = type(n) is int and 1 <= n <= 10
        need(fits, "the order must be a whole number from 1 to 10")
        # Pade's quotient p(-s tau)/p(s tau) of order n; the common factor of all its coefficients,
        # which cancels, is left out, so that they are integers.
        weights = [comb(n, i) * factorial(2 * n - i) for i in range(n + 1)]
        numerator = [f"{c}*(-s*tau)^{i}" for i, c in enumerate(weights)]
        denominator = [f"{c}*(s*tau)^{i}" for i, c in enumerate(weights)]
        return ["tau", " + ".join(numerator), "0", "0", " + ".join(denominator)]
    if model == "sampled-loop":
        method = given.pop("method", None)
        n = given.pop("delay", 0)
        fits = type(n) is int and 0 <= n <= 20
        need(fits, "the delay must be a whole number of samples, from 0 to 20")
        # u/v = exp(-s T), so v/u is z. Without a method what is rendered is in z itself.
        clock = "v/u" if method is None else CATALOGUE["clocks"].get(str(method))
        need(clock is not None, "the method of a clock is not understood")
        return ["T@1", f"u^{n}*(v - u)", "0", "0", f"s*T*v^{n + 1}", str(clock)]
    models = CATALOGUE["models"]
    full = model
    # Some models have a second form, for other parameters: with a dynamics Z, or with a delay tau.
    for key in ("tau", "Z"):
        variant = f"{model} {key}"
        if key in given and variant in models:
            full = variant
    need(full in models, f"the model {model!r} is not understood")
    return list(models[full])


class Element:
    """An environment (one formula) or an effect (four), with the numbers that the names in them
    stand for."""

    def __init__(self, table: Any, formulas: int, felt: "Element | None" = None) -> None:
        """``felt``: the environment whose parameters what is rendered may refer to."""
        has_model = isinstance(table, dict) and isinstance(table.get("model"), str)
        need(has_model, "an environment or effect has no model")
        model = table["model"]
        given = {key: x for key, x in table.items() if key not in ("model", "name")}
        own = given.pop("parameters", {})
        self.in_z = model == "difference-equation"
        signature, *self.texts = row(model, given)
        # A mark in the signature: "?" a parameter that may be left out, "=" a formula of the scene,
        # "@n" a delay whose n-fold is the lag, "^" the order of a power.
        names = {re.split("[=?@^]", x)[0]: x for x in signature.split()}
        needed = {key for key, x in names.items() if "?" not in x}
        in_formulas = "=" in signature
        fits = len(self.texts[:4]) == formulas and isinstance(own, dict)
        named = needed <= given.keys() <= names.keys()
        own_allowed = not own or in_formulas
        need(fits and named and own_allowed, f"the parameters of {model} are not understood")
        if in_formulas:
            # The scene's formulas take the places of the capitals in those of the model.
            inserted = lambda x: str(given[x[0]])  # noqa: E731
            self.texts = [re.sub(r"\b[A-Z]\b", inserted, text) for text in self.texts]
            lag = {key for key, x in names.items() if "@" in x and key in given}
            formulas_given = [x for key, x in given.items() if key not in lag]
            words = {*own, *re.findall(r"\w+", str(formulas_given))}
            # u and v are what the model calls the parts of exp(-s lag).
            reserved = {"u", "v", *lag} if lag else set[str]()
            need(not reserved & words, "a name stands for two numbers")
            self.numbers = {key: self.number(x, "", felt) for key, x in own.items()}
            self.numbers |= {key: self.number(given[key], "t", felt) for key in lag}
            if self.in_z:
                # Its z is the variable at which the element is computed, as s is elsewhere;
                # ``SceneFile.at`` puts the clock's value there.
                need("s" not in words and "z" not in own, "no difference equation in z")
                self.texts = [re.sub(r"\bz\b", "s", text) for text in self.texts]
        else:
            self.numbers = {}
            for key in names:
                kind = key if key in CATALOGUE["dimensions"] else key[0].lower()
                self.numbers[key] = self.number(given.get(key, 0), kind, felt)
        self.lag: Fraction | None = None
        self.order: Fraction | None = None
        for key, mark in names.items():
            if "@" in mark and key in self.numbers:
                delay = self.numbers[key]
                # A delay with pi is a multiple of none of the proof's, which are rational.
                fits = not delay.pi and delay.value >= 0
                need(fits, "a delay is negative, or has pi in it")
                multiple = int(mark[-1])
                self.lag = (self.lag or 0) + multiple * delay.value
            if "^" in mark:
                order = self.numbers[key]
                fits = not order.pi and 0 < order.value < 1
                need(fits, "an order is not a number between 0 and 1")
                self.order = order.value

    @staticmethod
    def number(given: Any, kind: str, felt: "Element | None") -> DimensionedNumber:
        """A parameter's value, or that of the environment's parameter that it refers to."""
        prefix = "environment."
        if isinstance(given, str) and felt and given.strip().startswith(prefix):
            name = given.strip().removeprefix(prefix)
            name = re.sub(r"\[(\d+)\]$", r"_\1", name)  # k[2] is the number k_2
            need(name in felt.numbers, f"{given[:60]!r} is no parameter of the environment")
            return felt.numbers[name]
        return quantity(given, kind)

    def at(self, point: ChainPoint) -> list[Ratio]:
        """The formulas' values; u/v is exp(-s lag), z is s^alpha."""
        known = {name: x.at(point.pi) for name, x in self.numbers.items()}
        known["s"] = point.s
        known["j"] = GaussianValue(0, 1), ONE
        known["pi"] = DimensionedNumber(Fraction(1), 1).at(point.pi)
        if self.lag is not None:
            u = point.delayed(self.lag)
            known["u"] = u, ONE
            known["v"] = u.conjugate(), ONE
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
            a, m = x
            b, n = y
            if sign == "*":
                return combined(sign, a, b), m + n
            if sign == "/":
                return combined(sign, a, b), m - n
            # Multiples of one power, without s: the power stays, and may yet meet another one.
            constants = all(max(v.degrees) <= 0 for v in (*a, *b))
            alike = m == n and constants
            # The polynomial 0, whose degree is below all others, leaves the other term its power.
            a_is_0, b_is_0 = (top.degrees[0] < 0 for top, _ in (a, b))
            if alike or a_is_0 or b_is_0:
                return combined(sign, a, b), n if a_is_0 else m
            return combined(sign, shifted(a, m), shifted(b, n)), Fraction(0)

        return [shifted(*evaluated(x, leaf, both)) for x in self.texts]


def tables(x: Any) -> list[dict[str, Any]]:
    """A list of tables of a file, at most 100; refused if it is none."""
    is_short = isinstance(x, list) and len(x) <= 100
    fits = is_short and {*map(type, x)} <= {dict}
    need(fits, "a list of at most 100 tables is none")
    return list(x)


def leave_free(table: Any, path: Any) -> None:
    """Put FREE for a number of a file: its path has keys, and places in lists from 0."""
    try:
        for x in path:
            is_place = type(x) is int and x >= 0
            need(type(x) is str or is_place, "a path is not understood")
        last = path[-1]
        place = reduce(getitem, path[:-1], table)
        quantity(place[last])
        place[last] = FREE
    except (LookupError, TypeError):
        raise RefusedError("the scene has no such number") from None


def carried(table: Any) -> list[dict[str, Any]]:
    """What a file's device puts at the hand: a shunt of its mass and damping, and its friction at
    an amplitude."""
    keys = {"like", "m", "b", "friction", "amplitude"}
    need(isinstance(table, dict) and table.keys() <= keys, "[device] is not understood")
    devices = CATALOGUE["devices"]
    name = str(table.get("like"))
    need(name in devices, "the device is not known")
    own = {**devices[name], **table}
    shunt = {key: own[key] for key in ("m", "b") if key in own}
    rubs = "amplitude" in own
    has_friction = "friction" in own or not rubs
    need(shunt and has_friction, "a number of the device is missing")
    effects = [{"model": "shunt", **shunt}]
    if rubs:
        effects.append(
            {
                "model": "coulomb-friction",
                "force": own.get("friction"),
                "amplitude": own["amplitude"],
            }
        )
    return effects


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


def read(data: bytes) -> dict[str, Any]:
    """The tables of a scene file, with all of its numbers exact."""
    steps = sum(line.count(b".") ** 2 for line in data.splitlines())
    if steps > MOST_STEPS:
        why = "the scene has too many dots in a line: keys of so many parts are not read"
        raise UnreadableError(why)
    # 0.1 is 1/10: no float is ever made of a number of the file.
    exact = lambda x: quantity(x.replace("_", "")).value  # noqa: E731
    try:
        table = tomllib.loads(data.decode("utf-8-sig"), parse_float=exact)
    except (ValueError, RecursionError) as error:
        raise UnreadableError(f"the scene is no TOML: {error}") from None
    unknown = sorted(table.keys() - KEYS)
    need(not unknown, f"keys of the scene are not understood: {unknown}")
    return table


def choose_environment(table: dict[str, Any], name: str | None) -> None:
    """Put one of a file's environments, and what is rendered for it, where those of a file with
    one stand."""
    rows = tables(table.get("environments"))
    named = [x for x in rows if x.get("name", x.get("model")) == name]
    one = isinstance(name, str) and len(named) == 1
    beside = table.keys() & {"environment", "rendered"}
    need(one and not beside, f"there is not one environment {name!r}")
    environment = dict(named[0])
    if "rendered" in environment:
        table["rendered"] = environment.pop("rendered")
    table["environment"] = environment


class SceneFile:
    """Band, thresholds and hands of a scene file, and its chain."""

    def __init__(self, data: bytes, name: str | None, free: list[str | int] | None = None) -> None:
        """``name``: which of several environments; ``free``: the keys, in the file, of a number
        that is left free."""
        table = read(data)
        if "environments" in table or name is not None:
            choose_environment(table, name)
        if free is not None:
            leave_free(table, free)
        self.felt = Element(table.get("environment"), 1)
        self.rendered = self.felt
        if "rendered" in table:
            self.rendered = Element(table["rendered"], 1, self.felt)
        worn = carried(table["device"]) if "device" in table else []
        # The device is nearest to the hand, so its effects come last.
        effects = [*tables(table.get("effects", [])), *worn]
        self.effects = [Element(x, 4) for x in effects]
        told = table.get("evaluation", {})
        has_clock_in_z = any(x.texts[4:] == ["v/u"] for x in self.effects)
        fits = self.rendered.in_z == has_clock_in_z
        need(fits and not self.felt.in_z, "a clock and what it renders do not fit")
        elements = [self.felt, self.rendered, *self.effects]
        texts = [text for element in elements for text in element.texts]
        self.length = sum(map(len, texts))
        fits = isinstance(told, dict) and told.keys() <= {"band", "jnd"}
        need(fits, "[evaluation] is not understood")
        band = told.get("band", [0, 15])
        jnd = told.get("jnd", Fraction(1, 10))
        need(isinstance(band, list) and len(band) == 2, "the band is not a pair")
        self.band = [quantity(x, "o") for x in band]
        both = jnd if isinstance(jnd, dict) else {"real": jnd, "imag": jnd}
        fits = both.keys() == {"real", "imag"}
        need(fits, "the threshold is not a number, nor one for each part")
        self.threshold = {part: quantity(x, "z") for part, x in both.items()}
        if free is not None:
            # The parameter takes the place of pi in every polynomial, so pi itself may stand
            # nowhere but in the band, which is not part of the functions.
            values = list(self.threshold.values())
            for element in elements:
                values += element.numbers.values()
            in_texts = any("pi" in words_of(text) for text in texts)
            in_values = any(x is not FREE and x.pi for x in values)
            alone = not in_texts and not in_values
            need(alone and FREE in values, "a parameter is free beside pi")
        hands = [table["hand"]] if "hand" in table else table.get("hands", [])
        self.hands = tables(hands)

    def hand(self, name: str) -> dict[str, Any]:
        """Mass, damping and stiffness in the file."""
        named = [x for x in self.hands if x.get("name", "hand") == name]
        fits = len(named) == 1 and "model" not in named[0]
        need(fits, f"the scene has not one hand {name!r}")
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
        is_first = len(clocks) == 1 and effects[0][4:]
        need(not clocks or is_first, "a clock that is not the first effect")
        rendered_at = point
        if clocks:
            rendered_at = point._replace(s=clocks[0], orders=())
        [(top, bottom)] = self.rendered.at(rendered_at)
        # Each effect is a matrix [[a/x, b/y], [c/z, d/w]] and makes of a dynamics H
        # (a/x H + b/y)/(c/z H + d/w); both sides are multiplied by x y z w.
        for (a, x), (b, y), (c, z), (d, w), *_ in effects:
            above = a.times(y).times(top).plus(b.times(x).times(bottom))
            below = c.times(w).times(top).plus(d.times(z).times(bottom))
            top = above.times(z.times(w))
            bottom = below.times(x.times(y))
        [felt] = self.felt.at(point)
        return felt, (top, bottom)


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
        last = len(factors) - 1
        self.powers = {whole(i, 0, last): whole(n, -100, 100) for i, n in rows}
        need(len(self.powers) == len(rows), "a factor stands twice in a product")
        need(self.number or not rows, "a function that is zero everywhere has no factors")
        self.size = 0
        degrees = []
        for i, n in self.powers.items():
            self.size += abs(n) * factors[i].size
            degrees.append([n * k for k in factors[i].waves])
        waves = [sum(column) for column in zip(*degrees, strict=True)]
        # A factor of degree n in sine and cosine is cos^n times a polynomial in the tangent t. An
        # odd power of the cosine is no rational function of t; an even one is, by
        # cos^2 = 1/(1 + t^2).
        need(not any(n % 2 for n in waves), "a product changes its sign in a turn")
        self.circles = [-n // 2 for n in waves]

    def at(self, factors: list[GaussianValue], circles: list[GaussianValue]) -> Ratio:
        """Numerator and denominator, with values of the factors and of 1 + t^2 for each tangent
        t."""
        top = GaussianValue(self.number.numerator)
        bottom = GaussianValue(self.number.denominator)
        powers = [(factors[i], n) for i, n in self.powers.items()]
        powers += zip(circles, self.circles, strict=False)
        for x, n in powers:
            raised = x.power(abs(n))
            if n < 0:
                bottom = bottom.times(raised)
            else:
                top = top.times(raised)
        return top, bottom


def functions(
    scene: SceneFile, delays: Numbers, orders: Numbers, omega: GaussianValue, pi: int, *others: Any
) -> dict[str, Ratio]:
    """The ten functions, numerator and denominator, at a frequency."""
    s = omega.times(GaussianValue(0, 1))
    h, g = scene.at(ChainPoint((s, ONE), pi, delays, orders, others))
    pairs = {
        "environment": h,
        "perceived": g,
        "difference": combined("-", g, h),
        "sum": combined("+", g, h),
    }
    ratios: dict[str, Ratio] = {}
    for name, (u, v) in pairs.items():
        # u/v = u conj(v)/|v|^2
        turned = u.times(v.conjugate())
        bottom = v.times(v.conjugate())
        ratios[f"{name}.real"] = turned._replace(im=0), bottom
        ratios[f"{name}.imag"] = turned._replace(re=turned.im, im=0), bottom
    # With H = N/D and G = P/Q, and Im as Re:
    # (Re (G - H))^2/|H|^2 = (Re ((P D - Q N) conj(D Q)))^2/(|N|^2 |D|^2 |Q|^4).
    n, d = h
    _, q = g
    root = n.times(d).times(q).times(q)
    bottom = root.times(root.conjugate())
    for part in PARTS:
        y, _ = ratios[f"difference.{part}"]
        limit = scene.threshold[part].at(pi)
        ratio = y.times(y), bottom
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
        self.told = told
        self.factors = factors
        self.scene = scene
        self.delays = delays
        self.orders = orders
        # Any one point shows the degrees: they do not depend on the values.
        tangents = [0] * delays
        powers = [(0, 0)] * orders
        self.start = self.sides(0, 1, *tangents, *powers)

    def sides(self, x: int, pi: int, *others: Any) -> dict[str, Sides]:
        """Numerator and denominator of each function in the scene, and as told."""
        tangents = others[: self.delays]
        powers = others[self.delays :]
        circles = []
        # The tangents have the places from 2 on among the variables.
        for i, t in enumerate(tangents, 2):
            circles.append(GaussianValue(1 + t * t, 0, degree(i, 2)))
        variables = [*tangents, *chain(*powers)]
        values = [factor.at(x, pi, variables) for factor in self.factors]
        omega = GaussianValue(x, 0, degree(0))
        functions = self.scene(omega, pi, *others)
        sides = {}
        for name, told in self.told.items():
            sides[name] = (*functions[name], *told.at(values, circles))
        return sides

    def elsewhere(self, k: int) -> dict[str, Sides]:
        """The same at a place that differs from others in all numbers."""
        tangents = range(k + 2, k + 2 + self.delays)
        powers = [(k + 3 + i, k + 4) for i in range(self.orders)]
        return self.sides(k, k + 1, *tangents, *powers)

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
        tangents = size[: self.delays]
        powers = size[self.delays :]
        corners = [k * (k + 1) // 2 for k in powers]
        count = n * m * prod(tangents + corners)
        fits = n <= 3000 and count * cost <= 3 * 10**7
        need(fits, "the degrees are too high")
        axes: list[Iterable[Any]] = [range(n), range(1, m + 1)]
        axes += map(range, tangents)
        for most in powers:
            axes.append([(i, k) for i in range(most) for k in range(most - i)])
        for at in product(*axes):
            # What is not zero somewhere is not looked at any more.
            if not names:
                break
            sides = self.sides(*at)
            wrong = [name for name in names if not all_zero(across(name, sides[name]))]
            need(not wrong, f"{', '.join(sorted(wrong))}: not that of the scene")
            names = {name for name in names if all_zero(rests(name, sides[name]))}
        return names


def all_zero(values: list[GaussianValue]) -> bool:
    """Whether all of these numbers are zero."""
    return all(x.re == 0 == x.im for x in values)


def across(_: str, x: Sides) -> list[GaussianValue]:
    """left bottom - right top: zero where both fractions are one function."""
    top, bottom, told_top, told_bottom = x
    left = told_top.times(bottom)
    right = told_bottom.times(top)
    return [left.plus(right, -1)]


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
    products = zip(names, keyed(x, *names), strict=True)
    told = {name: FactoredNumber(y, factors) for name, y in products}
    of_factors = sum(x.size for x in factors)
    of_products = sum(x.size for x in told.values())
    cost = share * (of_factors + of_products + 5 * length + 100)
    grid = FunctionGrid(told, factors, scene, *waves)
    fixed: dict[str, tuple[GaussianValue, GaussianValue]] = {}
    # Across, 0 bottom = right 0 would fit anything. One point where neither denominator is zero
    # shows that neither is the polynomial 0.
    for k in range(17, 25):
        if len(fixed) == len(told):
            break
        for name, (_, bottom, _, told_bottom) in grid.elsewhere(k).items():
            if told_bottom.re and not all_zero([bottom]):
                fixed[name] = told_bottom, bottom
    need(len(fixed) == len(told), "a function is nowhere defined")

    def multiples(name: str, x: Sides) -> list[GaussianValue]:
        """What vanishes where the scene's numerator and denominator are those told, times one
        number."""
        u, v = (y._replace(degrees=degree(0, 0)) for y in fixed[name])
        top, bottom, told_top, told_bottom = x
        return [
            top.times(u).plus(told_top.times(v), -1),
            bottom.times(u).plus(told_bottom.times(v), -1),
        ]

    # If numerators and denominators agree up to one number, polynomials of about half the degree
    # are to be tested, on a smaller grid. Where something was cancelled the larger one is needed.
    left = set(names) - grid.zero(set(names), multiples, cost)
    proven = not left or grid.zero(left, across, cost) == left
    need(proven, "a function is not that of the scene")
    return told
