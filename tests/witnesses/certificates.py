"""Certificates to test checkers with: true ones, mutants that prove less than they claim, and hostile documents."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Iterator
from fractions import Fraction
from functools import cache, reduce
from itertools import product
from operator import getitem
from pathlib import Path
from typing import Any

from jnds import inline, picked
from scenetexts import toml
from strategies import Seeded, case, coincident_case

import haptisym as hs
from haptisym.judge.evaluation import Evaluation
from haptisym_check import RefusedError, check

SCENES = Path(hs.__file__).parent / "scenes"
RATIONAL = (
    "admittance-display", "control-stick-in-detail", "desktop-device-soft-tissue", "fu2019", "fu2019-tolerances",
    "helicopter-cyclic", "sidestick", "steering-wheel", "stick-with-friction", "zener-tissue",
)  # fmt: skip
DELAYED = (
    "delayed-spring", "four-channel-teleoperation", "position-force-teleoperation", "sampled-wall", "satellite-contact", "virtual-wall",
    "wave-variable-link", "two delays", "a clock", "a delay, and pi",
)  # fmt: skip
"""Scenes with delays and holds."""
RAISED = ("a spring-pot", "powers alone", "orders of a formula", "organ-tissue")
"""Scenes with powers of s that are not whole, the cheapest to check first."""
OWN = {
    "unstable": '[environment]\nmodel = "mass-spring-damper"\nm = 1\nb = 5\nk = 100\n[[effects]]\nmodel = "series"\n'
                'G = "100/(s^2 - 0.1*s + 100)"\n[evaluation]\nband = [0, 30]\n',
    "pole on the axis": '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 1\n[[effects]]\nmodel = "series"\nG = "w^2/(s^2 + w^2)"\n'
                        'parameters = { w = "2 Hz" }\n[evaluation]\nband = ["0 Hz", "1 Hz"]\n',
    "integrator": '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 1\n[[effects]]\nmodel = "series"\nG = "1 + 1/s"\n'
                  '[evaluation]\nband = [1, 30]\n',
    "touches": '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 0\n[[effects]]\nmodel = "series"\nG = "3*s/(s^2 + 3*s + 9)"\n'
               '[evaluation]\nband = [0, 9]\njnd = 1\n',
    "crossing at the end": '[environment]\nmodel = "mass-spring-damper"\nk = 100\n[[effects]]\nmodel = "shunt"\nm = "1 kg"\n'
                           '[evaluation]\nband = [0, 5]\njnd = "1/4"\n',
    "a device": '[environment]\nmodel = "kelvin-voigt"\nk = 290\nb = 2\n[device]\nlike = "one-axis"\nb = "1 N*s/m"\namplitude = "5 cm"\n'
                '[[effects]]\nmodel = "first-order-lag"\nomega_c = 600\n[evaluation]\nband = [0, 60]\n',
    "nothing between": '[environment]\nmodel = "prony"\nk0 = 100\nk = [50, 20]\nb = ["1 N*s/m", "2 N s/m"]\n',
}  # fmt: skip


_LATE = '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 5\n[[effects]]\nmodel = "delay"\ntau = "20 ms"\n'
LATE = {
    "two delays": _LATE + '[[effects]]\nmodel = "shunt"\nm = "1/10 kg"\n[[effects]]\nmodel = "delay"\ntau = "33.3 ms"\n',
    "a clock": '[environment]\nmodel = "kelvin-voigt"\nk = 500\nb = 3\n[[effects]]\nmodel = "sampled-loop"\nT = "2 ms"\n'
               'method = "tustin"\ndelay = 1\n[[effects]]\nmodel = "shunt"\nm = "45 g"\n[evaluation]\nband = [5, 60]\n',
    "a delay, and pi": _LATE + '[[effects]]\nmodel = "series"\nG = "1/(1 + s/(2*pi*f))"\nparameters = { f = "10 1/s" }\n'
                       '[evaluation]\nband = ["0 Hz", "2 Hz"]\n',
}  # fmt: skip
_LAGGED = '[[effects]]\nmodel = "first-order-lag"\nomega_c = 60\n'
FRACTIONAL = {
    "a spring-pot": '[environment]\nmodel = "spring-pot"\nk_alpha = "80 N*s^0.3/m"\nalpha = 0.3\nk = 20\n' + _LAGGED,
    "powers alone": '[environment]\nmodel = "spring-pot"\nk_alpha = "80 mN*s^0.5/mm"\nalpha = "1/2"\n[[effects]]\nmodel = "shunt"\nm = "1/2"\n'
                    '[evaluation]\nband = [0, 30]\n',
    "orders of a formula": '[environment]\nmodel = "expression"\nH = "30 + s^(1.3) + 5*s^-.7"\n' + _LAGGED + '[evaluation]\nband = [1, 30]\n',
}  # fmt: skip


def text_of(name: str) -> str:
    own = OWN | LATE | FRACTIONAL | {"pole at 2 rad/s": OWN["pole on the axis"].replace('"2 Hz"', "2")}
    return own[name] if name in own else (SCENES / f"{name}.toml").read_text(encoding="utf-8")


def verdict(document: Any, scene: str) -> str:
    """What the checker says: the claim, or why not."""
    text = document if isinstance(document, str) else json.dumps(document)
    try:
        return check(text.encode("utf-8", "surrogatepass"), scene.encode())
    except RefusedError as error:
        return f"refused: {error}"


def of_scene(proof: Any, text: str) -> str:
    """The certificate with that scene's hash."""
    return json.dumps({**proof, "scene_sha256": hashlib.sha256(text.encode()).hexdigest()})


@cache
def evaluated(name: str) -> Evaluation:
    return hs.evaluate(hs.parse_scene(text_of(name)))


@cache
def certificate(name: str) -> str:
    return evaluated(name).certificate()


def random_scene(seed: int) -> str:
    """The text of one; of whole numbers a few are none, as their environment is zero."""
    text = toml((case if seed % 2 else coincident_case)(Seeded(seed)))
    try:
        hs.parse_scene(text)
    except hs.SceneError:
        return random_scene(seed + 1000)
    return text


def region_scene(seed: int) -> str:
    """The text of a random scene whose JND is a region, or a formula."""
    pick = Seeded(seed)
    text = re.sub("jnd = .*", f"jnd = {inline(picked(pick))}", random_scene(seed))
    try:
        hs.parse_scene(text)
    except hs.SceneError:  # a polygon that is not convex
        return region_scene(seed + 1000)
    return text


def late_scene(seed: int) -> str:
    """A random one with a delay or a hold behind it."""
    source, text = Seeded(seed), random_scene(seed)
    late = source.choice(
        [
            f'model = "delay"\ntau = "{source.whole(1, 60)} ms"',
            f'model = "zero-order-hold"\nT = "{source.whole(1, 30)} ms"',
        ]
    )
    before, mark, after = text.partition("[evaluation]")
    return f'{before}[[effects]]\nname = "late"\n{late}\n{mark}{after}'


def fractional_scene(seed: int) -> str:
    """A random one with powers of s, every other one with a delay behind them."""
    pick = Seeded(seed)
    order, k, c = pick.choice(["0.2", "0.3", '"1/2"', '"2/3"', "0.37", '"1/7"']), pick.whole(0, 200), pick.whole(1, 90)
    tissue = pick.choice([
        f'model = "spring-pot"\nk_alpha = {c}\nalpha = {order}\nk = {k}',
        f'model = "expression"\nH = "{k} + {c}*s^{pick.choice([1.3, 0.7, -0.4])} + {pick.whole(0, 3)}*s"',
        f'model = "expression"\nH = "{k + 1} + {c}*s^0.4/(1 + s^0.4/{pick.whole(1, 20)})"',
    ])  # fmt: skip
    between = [
        f'model = "shunt"\nm = "{pick.whole(1, 900)} g"',
        f'model = "first-order-lag"\nomega_c = {pick.whole(10, 200)}',
        f'model = "series"\nG = "1/(1 + s^0.5/{pick.whole(10, 90)})"',
        f'model = "delay"\ntau = "{pick.whole(1, 60)} ms"',
    ]
    first = between[pick.whole(0, 2)]
    own = [x for x in (first, *between[3:]) if x is first or seed % 2]
    band, jnd = [pick.choice([0, 0, 1]), pick.whole(5, 40)], f"{pick.whole(2, 30)}/100"
    listed = "".join(f'[[effects]]\nname = "e{i}"\n{x}\n' for i, x in enumerate(own))
    return f'[environment]\n{tissue}\n{listed}[evaluation]\nband = {band}\njnd = "{jnd}"\n'


def mutants(proof: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Changes of any certificate each of which makes the claim false, or the proof incomplete."""
    for path, value in [*leaves(proof)]:
        for what, other in others(path, value):
            changed = copy.deepcopy(proof)
            *above, last = path
            reduce(getitem, above, changed)[last] = other
            yield f"{'.'.join(map(str, path))}: {what}", changed
    for key in ("format", "scene_sha256", "environment", "claim", "proof"):
        yield f"{key} left out", {k: x for k, x in proof.items() if k != key}
    yield "a further key", {**proof, "note": ""}


def leaves(x: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Numbers, texts and empty lists with their paths."""
    inner = x.items() if isinstance(x, dict) else enumerate(x) if isinstance(x, list) else ()
    for key, y in inner:
        yield from [((*at, key), y)] if not isinstance(y, dict | list) or not y else leaves(y, (*at, key))


def others(path: tuple[Any, ...], value: Any) -> Iterator[tuple[str, Any]]:
    """What is false there: of breakpoints, enclosures, slabs and cells others may be as good."""
    if {*path} & {"breakpoints", "frequencies", "cells", "slabs"}:
        yield "no number", "1.5e0"
    elif isinstance(value, bool) or value is None:
        yield "otherwise", 7
    elif isinstance(value, int):
        yield from (("one more", value + 1), ("as a text", str(value)))
    elif value == [] and path[-1] not in ("delays", "orders", "powers"):
        yield "something", ["0"]
    elif isinstance(value, str) and re.fullmatch("-?[0-9/]+", value) and value != "0":
        yield from (
            ("another sign", str(-Fraction(value))),
            ("nearly", str(Fraction(value) * (1 + Fraction(1, 10**9)))),
        )
    elif isinstance(value, str) and not value.isdigit():
        yield "another word", "touches" if value != "touches" else "exceeds"


HELD = {
    "imposed": ("fu2019", ()), "a hand": ("fu2019", ("firm-grip", "postural-arm")), "unstable, held": ("unstable", ("postural-arm",)),
    "on the axis": ("pole at 2 rad/s", ("firm-grip",)), "with pi": ("admittance-display", ("postural-arm",)),
    "at 0": ("integrator", ("firm-grip",)),
}  # fmt: skip
"""Scene and hands of questions about stability."""


@cache
def stability(name: str) -> hs.Stability:
    """Its counts, for which the limits of parameters need not be known."""
    scene, hands = HELD[name]
    return hs.stability(hs.parse_scene(text_of(scene)), hands, limit=0.5)


@cache
def of_stability(name: str) -> tuple[str, str]:
    """A certificate, and the scene that it is about."""
    return stability(name).certificate(), text_of(HELD[name][0])


_WIDE = text_of("fu2019").replace("0.10", "0.5").replace('["0 rad/s", "15 rad/s"]', "[1, 40]")
ASKED = {
    "from a value on": (text_of("fu2019"), "omega_n"), "up to a value": (text_of("fu2019"), "zeta"),
    "none": (text_of("fu2019"), "environment.b"), "a threshold": (text_of("fu2019"), "evaluation.jnd"),
    "two intervals": (_WIDE, "environment.k"),
    "a parameter of a formula": (OWN["touches"].replace("3*s/(s^2 + 3*s + 9)", "20/(s + w)\"\nparameters = { w = 20 }\n#"), "w"),
}  # fmt: skip
_SHUNTED = (
    text_of("powers alone").replace('"80 mN*s^0.5/mm"', "17").replace('"1/2"\n[[', "0.2\nk = 190\n[[")
    + 'jnd = "7/100"\n'
)
WAVED = {
    "a threshold above a delay": (text_of("delayed-spring"), "evaluation.jnd"),
    "two ends beside a delay": (text_of("four-channel-teleoperation"), "environment.k"),
    "a clock's wall": (text_of("virtual-wall"), "environment.b"), "a device on a clock": (text_of("a clock"), "m"),
    "a power from 0 on": (_SHUNTED, "environment.k"), "a device on a power": (_SHUNTED, "effects.shunt.m"),
    "two orders": (text_of("orders of a formula").replace("band = [1, 30]", 'band = [1, 30]\njnd = "1/5"'), "omega_c"),
    "a lag on tissue": (text_of("organ-tissue"), "omega_c"),
}  # fmt: skip
"""Those with delays, holds, clocks and powers of s."""
ASKED |= WAVED
"""Scenes and parameters of requirements."""


@cache
def of_requirement(name: str) -> tuple[str, str]:
    """A certificate, and the scene that it is about."""
    text, path = ASKED[name]
    return hs.require(hs.parse_scene(text), path).certificate(), text


def known_roots(seed: int) -> tuple[str, int]:
    """A polynomial in s, and how many of its zeros lie in Re s >= 0: it is a product of factors of which that is known."""
    source, count, text = Seeded(seed), 0, "1"
    for _ in range(source.whole(1, 5)):
        a, b = source.whole(1, 9), source.whole(1, 9)
        factor, own = source.choice([
            (f"(s + {a})", 0), (f"(s - {a})", 1), (f"((s + {a})^2 + {b})", 0), (f"((s - {a})^2 + {b})", 2),
            (f"(s^2 + {a})", 2), (f"(s^2 - {a})", 1), ("s", 1), (f"(s^4 + {a})", 2), (f"(s^2 + {a}*w*s + {b})", 0),
        ])  # fmt: skip
        text, count = f"{text}*{factor}", count + own
    return text, count


HOSTILE = (
    "deep", "a huge whole number", "half a surrogate", "a million leaves", "fine breakpoints", "long numbers to high powers", "a high degree to high powers",
    "many coefficients, with pi", "many sines",  "long cells about roots", "many hands", "slabs without end", "fine slabs",
)  # fmt: skip


@cache
def hostile() -> tuple[tuple[str, str], ...]:
    """Documents about fu2019 that ask for more time or memory than there is, named as in ``HOSTILE``."""
    good, held, values = (
        json.loads(x) for x in (certificate("fu2019"), of_stability("a hand")[0], of_requirement("a threshold")[0])
    )
    n, slab = len(good["proof"]["factors"]), values["proof"]["slabs"][-1]

    def proven(document: dict[str, Any], **other: Any) -> str:
        return json.dumps({**document, "proof": {**document["proof"], **other}})

    def cancelling(factor: dict[str, Any], power: int, count: int = 1, **other: Any) -> str:
        """Factors above and below: what is claimed is true."""
        functions = copy.deepcopy(good["proof"]["functions"])
        functions["sum.imag"]["powers"] += [[n + i, power if i % 2 else -power] for i in range(2 * count)]
        return proven(good, factors=[*good["proof"]["factors"], *[factor] * 2 * count], functions=functions, **other)

    squares = [*product(range(17), range(17))]
    fine = [f"1/3{'0' * 1900}{i}" for i in range(999, 500, -1)]
    many = {"claim": {**held["claim"], "held": held["claim"]["held"] * 100}}
    texts = (
        "[" * 1_000_000,
        '{"format": 1' + "0" * 1_000_000 + "}",
        '{"format": "\\ud800"}',
        proven(good, breakpoints=[str(n) for n in range(400_000)]),
        proven(good, breakpoints=["0", *fine, *good["proof"]["breakpoints"][1:]]),
        cancelling({"step": 1, "polynomial": [["9" * 2000]]}, 100, 200),
        cancelling({"step": 1, "polynomial": [["1"]] * 150}, 40),
        cancelling({"step": 1, "polynomial": [["1"] * 20] * 60}, 1, 5),
        cancelling(
            {"waves": [16, 16], "terms": [[list(x), [["1"] * 100] * 10] for x in squares]}, 2, delays=["1/3", "1/7"]
        ),
        proven(held, held=[{**x, "cells": [fine[:299] for _ in x["cells"]]} for x in held["proof"]["held"]]),
        proven({**held, **many}, held=held["proof"]["held"] * 100),
        proven(values, slabs=[slab] * 20_000),
        proven(values, slabs=[{**slab, "points": ["0", *fine[:480], "15"]}] * 4),
    )
    return tuple(zip(HOSTILE, texts, strict=True))


CANCELLING = (
    ("300 + s^(1/4)*s^( 3 / 12 )", "300 + s^0.5"), ("300 + s^(4/2) + s^(-1/4)", "300 + s^2 + s^-0.25"),
    ("300 + s^0.5*s^0.5", "300 + s"), ("300 + s^0.5/s^0.5", "301"), ("300 + (s^0.5)^2", "300 + s"), ("300 + (s^-0.25)^(-2)", "300 + s^0.5"),
    ("300 + s^0.3*s^1.7", "300 + s^2"), ("300 - s^0.5*s^0.25/s^2", "300 - s^-1.25"), ("300 + (s^0.5 + s)/s^0.5", "301 + s^0.5"),
    ("300 + (2*s^0.5 + 0 - 3*s^0.5)*s^0.5", "300 - s"), ("300 + s^.2*(s^.3 + 9)*s^.5/s^.7", "300 + s^0.3 + 9"),
    ("300 + 1/(s^0.5*(s + 1) + s^0.5)", "300 + s^-0.5/(s + 2)"), ("300 + (0*s + s^0.5 - 0/s)*s^0.5", "300 + s"),
)  # fmt: skip
"""Formulas in which powers of s cancel, and what is left."""
