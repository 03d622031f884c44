"""What a scene file says: exact numbers, and the chain of its dynamics in Gaussian integers wherever it is asked for."""

import re
import tomllib
from fractions import Fraction
from functools import reduce
from math import comb, factorial
from operator import getitem
from typing import Any

from haptisym_check.formulas import CATALOGUE, FREE, Number, evaluated, quantity, words_of
from haptisym_check.values import ONE, Point, Ratio, RefusedError, UnreadableError, Value, combined, need

Powered = tuple[Ratio, Fraction]  # times s to that power: in a product they are added, as s^a s^b = s^(a + b)


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
        clock = "v/u" if method is None else CATALOGUE["clocks"].get(str(method))  # without a method: z itself
        need(clock is not None, "the method of a clock is not understood")
        return ["T@1", f"u^{n}*(v - u)", "0", "0", f"s*T*v^{n + 1}", str(clock)]
    full = next((f"{model} {x}" for x in ("Z", "tau") if x in given and f"{model} {x}" in CATALOGUE["models"]), model)
    need(full in CATALOGUE["models"], f"the model {model!r} is not understood")
    return list(CATALOGUE["models"][full])


class Element:
    """An environment (one formula) or an effect (four), with the numbers that the names in them stand for."""

    def __init__(self, table: Any, formulas: int, felt: "Element | None" = None) -> None:
        """``felt``: the environment whose parameters what is rendered may refer to."""
        need(isinstance(table, dict) and isinstance(table.get("model"), str), "an environment or effect has no model")
        model, given = table["model"], {key: x for key, x in table.items() if key not in ("model", "name")}
        own, self.lag = given.pop("parameters", {}), None
        self.in_z = model == "difference-equation"
        signature, *self.texts = row(model, given)
        names = {re.split("[=?@^]", x)[0]: x for x in signature.split()}
        needed = {key for key, x in names.items() if "?" not in x}
        fits = len(self.texts[:4]) == formulas and needed <= given.keys() <= names.keys() and isinstance(own, dict)
        need(fits and (not own or "=" in signature), f"the parameters of {model} are not understood")
        if "=" in signature:
            self.texts = [re.sub(r"\b[A-Z]\b", lambda x: str(given[x[0]]), text) for text in self.texts]
            lag = {key for key, x in names.items() if "@" in x and key in given}
            words = {*own, *re.findall(r"\w+", str([x for key, x in given.items() if key not in lag]))}
            need(not lag or not {"u", "v", *lag} & words, "a name stands for two numbers")
            self.numbers = {key: self.number(x, "", felt) for key, x in own.items()}
            self.numbers |= {key: self.number(given[key], "t", felt) for key in lag}
            if self.in_z:
                need("s" not in words and "z" not in own, "no difference equation in z")
                self.texts = [re.sub(r"\bz\b", "s", text) for text in self.texts]
        else:
            kinds = {key: key if key in CATALOGUE["dimensions"] else key[0].lower() for key in names}
            self.numbers = {key: self.number(given.get(key, 0), kind, felt) for key, kind in kinds.items()}
        lags = [(self.numbers[key], int(x[-1])) for key, x in names.items() if "@" in x and key in self.numbers]
        need(all(not x.pi and x.value >= 0 for x, _ in lags), "a delay is negative, or has pi in it")
        self.lag = sum((n * x.value for x, n in lags), Fraction(0)) if lags else None
        order = next((self.numbers[key] for key, x in names.items() if "^" in x), None)
        need(not order or (not order.pi and 0 < order.value < 1), "an order is not a number between 0 and 1")
        self.order = order and order.value

    @staticmethod
    def number(given: Any, kind: str, felt: "Element | None") -> Number:
        """A parameter's value, or that of the environment's parameter that it refers to."""
        if isinstance(given, str) and felt and given.strip().startswith("environment."):
            name = re.sub(r"\[(\d+)\]$", r"_\1", given.strip().removeprefix("environment."))
            need(name in felt.numbers, f"{given[:60]!r} is no parameter of the environment")
            return felt.numbers[name]
        return quantity(given, kind)

    def at(self, point: Point) -> list[Ratio]:
        """The formulas' values; u/v is exp(-s lag), z is s^alpha."""
        known = {name: x.at(point.pi) for name, x in self.numbers.items()}
        known |= {"s": point.s, "j": (Value(0, 1), ONE), "pi": Number(Fraction(1), 1).at(point.pi)}
        if self.lag is not None:
            u = point.delayed(self.lag)
            known |= {"u": (u, ONE), "v": (u.conjugate(), ONE)}
        if self.order is not None:
            known["z"] = point.raised(self.order)

        def leaf(word: str) -> Powered:
            if word.startswith("s^"):
                return (ONE, ONE), Fraction(word[2:])
            need(word in known or ("^" not in word and word[0] in "+-.0123456789"), f"the name {word!r} is not known")
            return known[word] if word in known else Number(Fraction(word)).at(point.pi), Fraction(0)

        def shifted(x: Ratio, n: Fraction) -> Ratio:
            return combined("*", x, point.raised(n)) if n else x

        def both(sign: str, x: Powered, y: Powered) -> Powered:
            (a, m), (b, n) = x, y
            if sign in "*/":
                return combined(sign, a, b), m + n if sign == "*" else m - n
            alike = m == n and all(max(v.degrees) <= 0 for v in (*a, *b))  # multiples of one power, without s
            nothing = [top.degrees[0] < 0 for top, _ in (a, b)]  # the polynomial 0, whose degree is below all others
            if alike or any(nothing):
                return combined(sign, a, b), n if nothing[0] else m
            return combined(sign, shifted(a, m), shifted(b, n)), Fraction(0)

        return [shifted(*evaluated(x, leaf, both)) for x in self.texts]


def tables(x: Any) -> list[dict[str, Any]]:
    """A list of tables, of a file."""
    need(isinstance(x, list) and len(x) <= 100 and {*map(type, x)} <= {dict}, "a list of at most 100 tables is none")
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


def carried(table: Any) -> list[dict[str, Any]]:
    """What a file's device puts at the hand: a shunt of its mass and damping, and its friction at an amplitude."""
    fits = isinstance(table, dict) and table.keys() <= {"like", "m", "b", "friction", "amplitude"}
    need(fits, "[device] is not understood")
    need(str(table.get("like")) in CATALOGUE["devices"], "the device is not known")
    own = {**CATALOGUE["devices"][str(table["like"])], **table}
    shunt = {key: own[key] for key in ("m", "b") if key in own}
    need(shunt and ("friction" in own or "amplitude" not in own), "a number of the device is missing")
    rubbing = {"model": "coulomb-friction", "force": own.get("friction"), "amplitude": own.get("amplitude")}
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


class Scene:
    """Band, thresholds and hands of a scene file, and its chain."""

    def __init__(self, data: bytes, name: str | None, free: list[str | int] | None = None) -> None:
        """``name``: which of several environments; ``free``: the keys, in the file, of a number that is left free."""
        try:
            table = tomllib.loads(data.decode("utf-8-sig"), parse_float=lambda x: quantity(x.replace("_", "")).value)
        except (ValueError, RecursionError) as error:
            raise UnreadableError(f"the scene is no TOML: {error}") from None
        need(table.keys() <= KEYS, f"keys of the scene are not understood: {sorted(table.keys() - KEYS)}")
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
        worn = carried(table["device"]) if "device" in table else []
        self.effects, told = (
            [Element(x, 4) for x in [*tables(table.get("effects", [])), *worn]],
            table.get("evaluation", {}),
        )
        elements = [self.felt, self.rendered, *self.effects]
        fits = self.rendered.in_z == any(x.texts[4:] == ["v/u"] for x in self.effects)
        need(fits and not self.felt.in_z, "a clock and what it renders do not fit")
        self.length = sum(len(text) for element in elements for text in element.texts)
        need(isinstance(told, dict) and told.keys() <= {"band", "jnd"}, "[evaluation] is not understood")
        band, jnd = told.get("band", [0, 15]), told.get("jnd", Fraction(1, 10))
        need(isinstance(band, list) and len(band) == 2, "the band is not a pair")
        self.band = [quantity(x, "o") for x in band]
        both = jnd if isinstance(jnd, dict) else {"real": jnd, "imag": jnd}
        need(both.keys() == {"real", "imag"}, "the threshold is not a number, nor one for each part")
        self.threshold = {part: quantity(x, "z") for part, x in both.items()}
        if free is not None:
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
        [(top, bottom)] = self.rendered.at(point._replace(s=clocks[0], orders=()) if clocks else point)
        for (a, x), (b, y), (c, z), (d, w), *_ in effects:
            above = a.times(y).times(top).plus(b.times(x).times(bottom))
            below = c.times(w).times(top).plus(d.times(z).times(bottom))
            top, bottom = above.times(z.times(w)), below.times(x.times(y))
        return self.felt.at(point)[0], (top, bottom)
