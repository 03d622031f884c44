"""Certificates to test checkers with: true ones, mutants that prove less than they claim, and hostile documents."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from pathlib import Path
from typing import Any

from jnds import inline, picked
from scenetexts import toml
from strategies import Seeded, case, coincident_case

import haptisym as hs
from haptisym.judge.evaluation import Evaluation

SCENES = Path(hs.__file__).parent / "scenes"
RATIONAL = (
    "admittance-display", "control-stick-in-detail", "desktop-device-soft-tissue", "fu2019", "fu2019-tolerances",
    "helicopter-cyclic", "sidestick", "steering-wheel", "stick-with-friction", "two-mass-resonance", "undamped-resonance",
    "zener-tissue",
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
    own = OWN | LATE | FRACTIONAL
    return own[name] if name in own else (SCENES / f"{name}.toml").read_text(encoding="utf-8")


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
    """Changes each of which makes the claim false, or the proof incomplete."""

    def changed(name: str, change: Callable[[dict[str, Any]], object]) -> tuple[str, dict[str, Any]]:
        other = copy.deepcopy(proof)
        change(other)
        return name, other

    factors, functions = proof["proof"]["factors"], proof["proof"]["functions"]
    inner = len(proof["proof"]["breakpoints"]) - 1
    for i in (
        range(1, inner) if inner < 12 and not proof["proof"]["delays"] + proof["proof"]["orders"] else ()
    ):  # some cells are finer than they must be
        yield changed(f"breakpoint {i} left out", lambda x, i=i: x["proof"]["breakpoints"].pop(i))
    yield changed("the last cell left out", lambda x: x["proof"]["breakpoints"].pop())
    yield changed("the first cell left out", lambda x: x["proof"]["breakpoints"].pop(0))
    for i, factor in enumerate(factors):
        for what, change in factor_mutants(factor):
            yield changed(f"{what} of factor {i}", lambda x, i=i, change=change: change(x["proof"]["factors"][i]))
    for what, change in others_mutants(proof["proof"]):
        yield changed(what, lambda x, change=change: change(x["proof"]))
    for name, told in functions.items():
        own = lambda x, name=name: x["proof"]["functions"][name]  # noqa: E731
        if told["number"] != "0":
            yield changed(
                f"{name} with another sign",
                lambda x, own=own, n=told["number"]: own(x).update(number=str(-Fraction(n))),
            )
            yield changed(
                f"{name} with another number",
                lambda x, own=own, n=told["number"]: own(x).update(number=str(Fraction(n) * 2)),
            )
            yield changed(f"{name} zero", lambda x, own=own: own(x).update(number="0"))
        for i in range(len(told["powers"])):
            yield changed(f"{name} without a factor", lambda x, own=own, i=i: own(x)["powers"].pop(i))
            yield changed(
                f"{name} with a square",
                lambda x, own=own, i=i: own(x)["powers"][i].__setitem__(1, own(x)["powers"][i][1] + 2),
            )
    for key, value in proof["claim"].items():
        yield changed(f"{key} not claimed", lambda x, key=key: x["claim"].pop(key))
        if isinstance(value, list):
            for i in range(len(value)):
                yield changed(f"{key} without {i}", lambda x, key=key, i=i: x["claim"][key].pop(i))
                yield changed(
                    f"{key} with {i} twice", lambda x, key=key, i=i: x["claim"][key].insert(i, x["claim"][key][i])
                )
    for i, row in enumerate(proof["claim"]["crossings"]):
        wrong = {"at": row["at"] + 1, "part": {"real": "imag", "imag": "real"}[row["part"]], "kind": "touches" if row["kind"] != "touches" else "exceeds",
                 "sign": -row["sign"] or 1, "multiplicity": row["multiplicity"] + 1}  # fmt: skip
        for key, other in wrong.items():
            yield changed(
                f"{key} of crossing {i}",
                lambda x, i=i, key=key, other=other: x["claim"]["crossings"][i].update({key: other}),
            )
        yield changed("true for 1", lambda x, i=i: x["claim"]["crossings"][i].update(multiplicity=True))
    for i, (low, high) in enumerate(proof["claim"]["frequencies"]):
        beyond = str(Fraction(high) + (Fraction(high) - Fraction(low) or Fraction(1, 1000)))
        yield changed(
            f"enclosure {i} beside it", lambda x, i=i, a=beyond: x["claim"]["frequencies"].__setitem__(i, [a, a])
        )
        yield changed(
            f"enclosure {i} reversed",
            lambda x, i=i, a=high, b=str(Fraction(low) - 1): x["claim"]["frequencies"].__setitem__(i, [a, b]),
        )
    yield changed("stable otherwise", lambda x: x["claim"].update(stable=not x["claim"]["stable"]))
    yield changed(
        "no poles", lambda x: x["proof"].update(poles=None) if x["claim"]["stable"] is not None else x.pop("proof")
    )
    poles = proof["proof"]["poles"]
    for what, change in zeros_mutants(poles, stable=proof["claim"]["stable"]) if poles else ():
        yield changed(what, lambda x, change=change: change(x["proof"]["poles"]))
    yield from frame_mutants(proof)


def others_mutants(proof: dict[str, Any]) -> Iterator[tuple[str, Callable[[dict[str, Any]], object]]]:
    """Changes of delays and orders."""
    listed = [(key, i, n) for key in ("delays", "orders") for i, n in enumerate(proof.get(key, []))]
    for key, i, n in listed:
        yield f"{key} without {i}", lambda x, key=key, i=i: x[key].pop(i)
        for by in (Fraction(1, 2), Fraction(10**9 + 1, 10**9), 2, -1, 0, 10**100):
            yield (
                f"{key}: {i} times {by}",
                lambda x, key=key, i=i, m=str(Fraction(n) * by): x[key].__setitem__(i, m),
            )


def factor_mutants(factor: dict[str, Any]) -> Iterator[tuple[str, Callable[[dict[str, Any]], object]]]:
    """Changes of one factor."""
    step = factor.get("step")
    if step and len(factor["polynomial"]) > 1:
        yield "step", lambda x: x.update(step=3 - step)
    for n, rows in enumerate([factor["polynomial"]] if step else [p for _, p in factor["terms"]]):
        own = lambda x, n=n: x["polynomial"] if "step" in x else x["terms"][n][1]  # noqa: E731
        yield f"degree {n}", lambda x, own=own: own(x).pop()
        for k, row in enumerate(rows):
            more = str(int(row[0]) + 1)
            yield f"coefficient {k} of {n}", lambda x, own=own, k=k, more=more: own(x)[k].__setitem__(0, more)
    for n, (turns, _) in enumerate(factor.get("terms", ())):
        yield f"term {n} left out", lambda x, n=n: x["terms"].pop(n)
        yield f"term {n} twice", lambda x, n=n: x["terms"].append(x["terms"][n])
        for k, turn in enumerate(turns):
            yield (
                f"a sine or a power more in term {n}",
                lambda x, n=n, k=k, m=turn + 1: x["terms"][n][0].__setitem__(k, m),
            )
    for k, most in enumerate(factor.get("waves", ())):
        yield "a cosine more", lambda x, k=k, m=most + 1: x["waves"].__setitem__(k, m)


def frame_mutants(proof: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Those of any question."""

    def changed(name: str, change: Callable[[dict[str, Any]], object]) -> tuple[str, dict[str, Any]]:
        other = copy.deepcopy(proof)
        change(other)
        return name, other

    for key in ("format", "scene_sha256", "environment", "claim", "proof"):
        yield changed(f"{key} left out", lambda x, key=key: x.pop(key))
        yield changed(f"{key} of another kind", lambda x, key=key: x.update({key: 7}))
    yield changed("another scene's hash", lambda x: x.update(scene_sha256="0" * 64))
    yield changed("a further key", lambda x: x.update(note=""))
    for question in ("stability", "evaluation", "requirement"):
        if question != proof["claim"]["question"]:
            yield changed(f"as {question}", lambda x, n=question: x["claim"].update(question=n))
    for key in proof["proof"]:
        yield changed(f"{key} not proven", lambda x, key=key: x["proof"].pop(key))


def zeros_mutants(zeros: dict[str, Any], *, stable: bool) -> Iterator[tuple[str, Callable[[dict[str, Any]], object]]]:
    """Changes of what shows how many zeros a function has in Re s >= 0."""
    for i, rows in enumerate(zeros["factors"]):
        yield f"factor {i} left out", lambda x, i=i: x["factors"].pop(i)
        yield f"factor {i} of lower degree", lambda x, i=i: x["factors"][i].pop()
        for k, row in enumerate(rows):
            other = str(int(row[0]) + 1)
            yield f"coefficient {k} of factor {i}", lambda x, i=i, k=k, n=other: x["factors"][i][k].__setitem__(0, n)
    for i, (_, n) in enumerate(zeros["function"]["powers"]):
        yield f"power {i} left out", lambda x, i=i: x["function"]["powers"].pop(i)
        yield f"power {i} of another exponent", lambda x, i=i, n=n: x["function"]["powers"][i].__setitem__(1, n + 1)
    yield "another number", lambda x: x["function"].update(number=str(2 * Fraction(x["function"]["number"])))
    for i, cells in enumerate(zeros["cells"]):
        yield f"cells of factor {i} left out", lambda x, i=i: x["cells"].pop(i)
        yield f"a cell of factor {i} from 0", lambda x, i=i: x["cells"][i].insert(0, "0")
        if cells:
            yield f"cells of factor {i} that descend", lambda x, i=i: x["cells"][i].append(x["cells"][i][0])
        if cells and stable:  # E and O have as many zeros as they can
            yield f"no cells of factor {i}", lambda x, i=i: x["cells"][i].clear()


HELD = {
    "imposed": ("fu2019", ()), "a hand": ("fu2019", ("firm-grip", "postural-arm")), "unstable, held": ("unstable", ("postural-arm",)),
    "on the axis": ("pole on the axis", ("firm-grip",)), "with pi": ("admittance-display", ("postural-arm",)),
    "at 0": ("integrator", ("firm-grip",)),
}  # fmt: skip
"""Scene and hands of questions about stability."""


@cache
def of_stability(name: str) -> tuple[str, str]:
    """A certificate, and the scene that it is about."""
    scene, hands = HELD[name]
    return hs.stability(hs.parse_scene(text_of(scene)), hands).certificate(), text_of(scene)


def stability_mutants(proof: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Changes each of which makes a claim about stability false, or its proof incomplete."""

    def changed(name: str, change: Callable[[dict[str, Any]], object]) -> tuple[str, dict[str, Any]]:
        other = copy.deepcopy(proof)
        change(other)
        return name, other

    claim, own = proof["claim"], proof["proof"]
    yield "a zero that cancels", with_a_zero_that_cancels(proof)
    for n in (-1, 1):
        yield changed(f"imposed {n:+d}", lambda x, n=n: x["claim"].update(imposed=claim["imposed"] + n))
        for i, row in enumerate(claim["held"]):
            yield changed(
                f"held {i} {n:+d}",
                lambda x, i=i, n=n, row=row: x["claim"]["held"][i].update(unstable=row["unstable"] + n),
            )
    for i, row in enumerate(claim["held"]):
        for key in ("m", "b", "k"):
            number = str(Fraction(row["hand"][key]) + 1)
            yield changed(
                f"{key} of hand {i}", lambda x, i=i, key=key, n=number: x["claim"]["held"][i]["hand"].update({key: n})
            )
        yield changed(f"hand {i} of another name", lambda x, i=i: x["claim"]["held"][i].update(hand="nobody"))
        yield changed(f"hand {i} without a proof", lambda x, i=i: x["proof"]["held"].pop(i))
        yield changed(f"hand {i} not claimed", lambda x, i=i: x["claim"]["held"].pop(i))
    rows = [("imposed", None, own["imposed"], claim["imposed"])]
    rows += [("held", i, x, claim["held"][i]["unstable"]) for i, x in enumerate(own["held"])]
    for key, i, x, count in rows:
        for what, change in zeros_mutants(x, stable=count == 0):
            place = (lambda y, i=i: y["proof"]["held"][i]) if key == "held" else (lambda y: y["proof"]["imposed"])
            yield changed(f"{key} {i}: {what}", lambda y, change=change, place=place: change(place(y)))
    yield from frame_mutants(proof)


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
    "a power from 0 on": (_SHUNTED, "environment.k_alpha"), "a device on a power": (_SHUNTED, "effects.shunt.m"),
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


def requirement_mutants(proof: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Changes each of which makes a claim about values false, or its proof incomplete."""

    def changed(name: str, change: Callable[[dict[str, Any]], object]) -> tuple[str, dict[str, Any]]:
        other = copy.deepcopy(proof)
        change(other)
        return name, other

    def moved(x: dict[str, Any], old: str, new: str) -> None:
        for row in x["claim"]["values"]:
            row[:2] = [new if y == old else y for y in row[:2]]
        for row in x["proof"]["slabs"]:
            row.update({key: new if row[key] == old else row[key] for key in ("from", "to")})

    values, slabs = proof["claim"]["values"], proof["proof"]["slabs"]
    for i, (low, high, holds) in enumerate(values):
        yield changed(f"interval {i} otherwise", lambda x, i=i, y=holds: x["claim"]["values"][i].__setitem__(2, not y))
        yield changed(f"interval {i} left out", lambda x, i=i: x["claim"]["values"].pop(i))
        if i:
            beyond = str(Fraction(low) - abs(Fraction(low)) / 1000)
            yield changed(f"interval {i} from before its end", lambda x, a=low, b=beyond: moved(x, a, b))
        if i + 1 < len(values):
            beyond = str(Fraction(high) + abs(Fraction(high)) / 1000)
            yield changed(f"interval {i} beyond its end", lambda x, a=high, b=beyond: moved(x, a, b))
    for i, slab in enumerate(slabs):
        last, part = slab["points"][-1], slab["part"]
        yield changed(f"slab {i} left out", lambda x, i=i: x["proof"]["slabs"].pop(i))
        yield changed(f"slab {i} twice", lambda x, i=i: x["proof"]["slabs"].insert(i, x["proof"]["slabs"][i]))
        yield changed(f"slab {i} without a point", lambda x, i=i: x["proof"]["slabs"][i]["points"].pop())
        yield changed(f"slab {i} with a point twice", lambda x, i=i, y=last: x["proof"]["slabs"][i]["points"].append(y))
        other = "real" if part is None else None
        yield changed(f"slab {i} otherwise", lambda x, i=i, y=other: x["proof"]["slabs"][i].update(part=y))
        yield changed(f"slab {i} of no part", lambda x, i=i: x["proof"]["slabs"][i].update(part="number"))
        if part is not None:
            yield changed(f"slab {i} beyond the band", lambda x, i=i: x["proof"]["slabs"][i].update(points=["1000"]))
    for i, part in enumerate(proof["claim"]["binds"]):
        other = {"real": "imag", "imag": "real"}[part]
        yield changed(f"another part binds at end {i}", lambda x, i=i, y=other: x["claim"]["binds"].__setitem__(i, y))
        yield changed(f"what binds at end {i} left out", lambda x, i=i: x["claim"]["binds"].pop(i))
    for key, wrong in {"free": ["evaluation", "band", 0], "parts": ["real", "real"]}.items():
        yield changed(f"other {key}", lambda x, key=key, wrong=wrong: x["claim"].update({key: wrong}))
    for wrong in (
        [],
        ["title"],
        ["environment"],
        ["environment", []],
        ["effects", 7, "zeta"],
        ["environment", "model"],
        "title",
        None,
        {},
    ):
        yield changed(f"{wrong} free", lambda x, wrong=wrong: x["claim"].update(free=wrong))
    for name, told in proof["proof"]["functions"].items():
        own = lambda x, name=name: x["proof"]["functions"][name]  # noqa: E731
        number = str(-Fraction(told["number"]))
        yield changed(f"{name} with another sign", lambda x, own=own, n=number: own(x).update(number=n))
        for n in range(len(told["powers"][-1:])):
            yield changed(f"{name} without a factor", lambda x, own=own, n=n: own(x)["powers"].pop(n - 1))
        yield changed(f"{name} not told", lambda x, name=name: x["proof"]["functions"].pop(name))
    for what, change in others_mutants(proof["proof"]):
        yield changed(what, lambda x, change=change: change(x["proof"]))
    for i, factor in enumerate(proof["proof"]["factors"]):
        for what, change in factor_mutants(factor) if "waves" in factor else ():
            yield changed(f"{what} of factor {i}", lambda x, i=i, change=change: change(x["proof"]["factors"][i]))
        for k, row in enumerate(factor.get("polynomial", ())):
            more = str(int(row[-1]) + 1)
            yield changed(
                f"coefficient {k} of factor {i}",
                lambda x, i=i, k=k, n=more: x["proof"]["factors"][i]["polynomial"][k].__setitem__(-1, n),
            )
    yield from frame_mutants(proof)


def with_a_zero_that_cancels(proof: dict[str, Any]) -> dict[str, Any]:
    """(s - 1)/(s - 1) times 1/H_perc, and the zero counted: every function is as before."""
    other = copy.deepcopy(proof)
    imposed = other["proof"]["imposed"]
    n = len(imposed["factors"])
    imposed["factors"] += [[["-1"], ["1"]], [["-1"], ["1"]]]
    imposed["cells"] += [[], []]
    imposed["function"]["powers"] += [[n, 1], [n + 1, -1]]
    other["claim"]["imposed"] += 1
    return other


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


HOSTILE = {
    "nothing": "",
    "no object": "[]",
    "not a number": '{"format": NaN}',
    "infinite": '{"format": Infinity}',
    "deep": "[" * 1_000_000,
    "deep objects": '{"a":' * 200_000,
    "twice": '{"format": "haptisym.certificate/1", "format": "haptisym.certificate/1"}',
    "large": " " * 5_000_000,
    "a huge whole number": '{"format": 1' + "0" * 1_000_000 + "}",
    "a float": '{"format": 1.5}',
    "half a surrogate": '{"format": "\\ud800"}',
}


@cache
def hostile() -> tuple[tuple[str, str], ...]:
    """As ``_hostile`` tells them."""
    return tuple(_hostile())


def _hostile() -> Iterator[tuple[str, str]]:
    """Documents that ask for more time or memory than there is, or for what is not there."""
    yield from HOSTILE.items()
    good = json.loads(certificate("fu2019"))

    def with_proof(**other: Any) -> str:
        return json.dumps({**good, "proof": {**good["proof"], **other}})

    first = good["proof"]["factors"][0]
    yield "a million leaves", with_proof(breakpoints=[str(n) for n in range(400_000)])
    yield "breakpoints as high as one likes", with_proof(breakpoints=["0", "1E999", "15"])
    yield "breakpoints as long as one likes", with_proof(breakpoints=["0", "1/" + "9" * 1_000_000, "15"])
    yield "fine breakpoints", with_proof(breakpoints=["0", *(f"{n}/1{'0' * 1500}" for n in range(1, 1000)), "15"])
    yield "a long coefficient", with_proof(factors=[{"step": 2, "polynomial": [["9" * 3_000_000]]}])
    yield "a high degree", with_proof(factors=[{"step": 2, "polynomial": [["1"]] * 300}] * 400)
    yield "high powers of pi", with_proof(factors=[{"step": 2, "polynomial": [["1"] * 100] * 100}] * 20)
    powers = {
        name: {**x, "powers": [[i, 100] for i in range(len(good["proof"]["factors"]))]}
        for name, x in good["proof"]["functions"].items()
    }
    yield "high exponents", with_proof(functions=powers)
    yield "a factor that is not there", with_proof(factors=[first])
    yield "lists for numbers", with_proof(breakpoints=[[], {}])
    yield "null", with_proof(functions=None)
    yield "other digits", with_proof(breakpoints=["٣", "15"])
    yield from _hostile_waves(with_proof)
    root = {"step": 1, "polynomial": [[str(-(7**200))], *[["0"]] * 199, ["1"]]}
    long = [
        ["6." + "9" * 1990, "7." + "0" * 1990 + "1"] if i == 1 else x
        for i, x in enumerate(good["claim"]["frequencies"])
    ]
    factors = {**good["proof"], "factors": [*good["proof"]["factors"], root]}
    yield (
        "long enclosures of a zero",
        json.dumps({**good, "claim": {**good["claim"], "frequencies": long}, "proof": factors}),
    )
    yield from _hostile_powers(good)
    held = json.loads(of_stability("a hand")[0])
    cells = [[str(n) for n in range(1, 301)] for _ in held["proof"]["imposed"]["cells"]]
    yield (
        "many cells about a wrong count",
        json.dumps(
            {
                **held,
                "claim": {**held["claim"], "imposed": 1},
                "proof": {**held["proof"], "imposed": {**held["proof"]["imposed"], "cells": cells}},
            }
        ),
    )
    values = json.loads(of_requirement("from a value on")[0])
    slab = values["proof"]["slabs"][-1]
    points = [f"{n}/3{'0' * 1000}" for n in range(500)]
    far = ["0", "15", *(f"{n}E999" for n in range(1, 400))]
    for name, slabs in {
        "slabs without end": [slab] * 20_000,
        "fine slabs": [{**slab, "points": points}] * 7,
        "slabs of far points": [{**slab, "from": str(n), "to": str(n + 1), "points": far} for n in range(100, 500)],
    }.items():
        yield name, json.dumps({**values, "proof": {**values["proof"], "slabs": slabs}})
    wide = {"step": 1, "polynomial": [["1"] * 100]}
    other = json.loads(of_requirement("a threshold")[0])
    first = len(other["proof"]["factors"])
    other["proof"]["factors"] += [wide, wide]
    for told in other["proof"]["functions"].values():
        told["powers"] += [[first, 1], [first + 1, -1]]
    ends = {"from": f"1.{'3' * 1900}", "to": f"2.{'3' * 1900}"}
    other["proof"]["slabs"] = [{**other["proof"]["slabs"][-1], **ends}]
    yield "many slices between long numbers", json.dumps(other)
    yield from many_small_ones()
    for free in (["effects"] * 9, ["environment", 10**5], [[], {}]):
        yield f"the path {free}", json.dumps({**values, "claim": {**values["claim"], "free": free}})


def hostile_slabs() -> Iterator[tuple[str, str, str]]:
    """Of requirements with waves, each with its scene: slabs and slices without end, of claims that are true."""
    proof, text = of_requirement("a clock's wall")
    good = json.loads(proof)
    slabs = good["proof"]["slabs"]
    kept = next(x for x in slabs if x["part"] is None)
    fine = [f"{n}/20" for n in range(401)]

    def with_proof(**other: Any) -> str:
        return json.dumps({**good, "proof": {**good["proof"], **other}})

    yield (
        "many cells",
        with_proof(
            slabs=[x if x is not kept else {**x, "points": [str(Fraction(n) * 6) for n in fine]} for x in slabs]
        ),
        text,
    )
    ends = [str(Fraction(kept["from"]) + (Fraction(kept["to"]) - Fraction(kept["from"])) * n / 300) for n in range(301)]
    many = [{**kept, "from": a, "to": b, "points": ["0", "30", "60", "90", "120"]} for a, b in pairwise(ends)]
    yield "many slabs", with_proof(slabs=[slabs[0], *many, slabs[-1]]), text
    first = next(x for x in good["proof"]["factors"] if "waves" in x)
    n = len(good["proof"]["factors"])
    for name, rows in (
        ("high powers of the value", [["1"] * 100] * 20),
        ("long coefficients", [["9" * 2000, "1" * 2000, "7" * 2000]] * 20),
    ):
        factor = {**first, "terms": [[x, rows] for x, _ in first["terms"]]}
        functions = {
            key: {**told, "powers": [*told["powers"], [n, 1], [n + 1, -1]]}
            for key, told in good["proof"]["functions"].items()
        }
        yield name, with_proof(factors=[*good["proof"]["factors"], factor, factor], functions=functions), text
    long = [{**kept, "from": f"{n}.{'3' * 1900}", "to": f"{n + 1}.{'3' * 1900}"} for n in range(15, 30)]
    factor = {**first, "terms": [[[0], [["1"] * 100]]], "waves": [0]}
    functions = {
        key: {**told, "powers": [*told["powers"], [n, 1], [n + 1, -1]]}
        for key, told in good["proof"]["functions"].items()
    }
    slices = with_proof(factors=[*good["proof"]["factors"], factor, factor], functions=functions, slabs=long)
    yield "many slices between long numbers", slices, text
    yield "delays without end", with_proof(delays=[f"1/{n}" for n in range(1, 100_000)]), text
    yield "a long delay", with_proof(delays=[f"{10**40}"]), text


def many_small_ones(times: float = 1) -> Iterator[tuple[str, str]]:
    """Each step is quick, and there are that many times too many of them: what is claimed is true all the same."""
    good = json.loads(certificate("fu2019"))
    own = good["proof"]
    first, n = len(own["factors"]), int(50 * times)
    own["factors"] += [{"step": 1, "polynomial": x} for x in ([["0"], ["1"]], [["0", "1"]]) for _ in range(2)]
    for told in own["functions"].values():
        told["powers"] += [[first + i, k] for i, k in enumerate((20, -20, n, -n))] if told["powers"] else []
    yield "many points of a grid", json.dumps(good)
    good = json.loads(certificate("fu2019"))
    own = good["proof"]
    own["factors"] += [{"step": 1, "polynomial": [["1"]]}] * (500 - len(own["factors"]))
    steps = int(1900 * times)
    every = {Fraction(x) for x in own["breakpoints"]} | {Fraction(15 * n, steps) for n in range(1, steps)}
    own["breakpoints"] = [str(x) for x in sorted(every)]
    yield "many cells of many factors", json.dumps(good)
    held = json.loads(of_stability("a hand")[0])
    rows, proofs = held["claim"]["held"], held["proof"]["held"]
    first = len(proofs[0]["factors"])
    proofs[0]["factors"] += [[["1"], ["1"]]] * 2
    proofs[0]["cells"] += [[], []]
    proofs[0]["function"]["powers"] += [[first, int(100 * times)], [first + 1, -int(100 * times)]]
    held["claim"]["held"], held["proof"]["held"] = rows[:1] * 100, proofs[:1] * 100
    yield "many hands", json.dumps(held)
    values = json.loads(of_requirement("a threshold")[0])
    values["proof"]["factors"] += [{"step": 1, "polynomial": [["1"]]}] * 150
    count = len(values["proof"]["factors"])
    for told in values["proof"]["functions"].values():
        told["powers"] += [[i, 1] for i in range(count - 150, count)]
    points = [f"{n}/{int(10 * times)}" for n in range(int(150 * times) + 1)]
    ends = [f"{n}" for n in range(100, 100 + int(200 * times))]
    slabs = [{"from": a, "to": b, "points": points, "part": None} for a, b in pairwise(ends)]
    values["proof"]["slabs"] = slabs
    values["claim"] |= {"values": [[ends[0], ends[-1], True]], "binds": []}
    yield "many slabs of many points", json.dumps(values)


def _hostile_powers(good: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Factors that cancel: what is claimed is true, and dearer to check than a checker need work."""
    for name, rows, count, n in (
        ("long numbers to high powers", [["9" * 2000]], 200, 100),
        ("a high degree to high powers", [["1"]] * 150, 1, 40),
        ("many coefficients, with pi", [["1"] * 20] * 60, 5, 1),
    ):
        other = copy.deepcopy(good)
        first = len(other["proof"]["factors"])
        other["proof"]["factors"] += [{"step": 1, "polynomial": rows}] * 2 * count
        own = other["proof"]["functions"]["sum.imag"]["powers"]
        own += [[first + i, n if i % 2 else -n] for i in range(2 * count)]
        yield name, json.dumps(other)
    held = json.loads(of_stability("a hand")[0])
    own = held["proof"]["imposed"]
    first = len(own["factors"])
    own["factors"] += [[["1"]] * 299] * 2
    own["cells"] += [[f"{n}/1{'0' * 1900}" for n in range(1, 300)], []]
    own["function"]["powers"] += [[first, 1], [first + 1, -1]]
    yield "long cells of a factor that cancels", json.dumps(held)


def _hostile_waves(with_proof: Callable[..., str]) -> Iterator[tuple[str, str]]:
    """The same with sines and cosines."""
    known = list(product(range(17), range(17)))
    for name, waves, terms in (
        ("many sines", [16, 16], [[list(x), [["1"]]] for x in known]),
        ("many terms", [16, 16], [[list(x), [["1"] * 100] * 30] for x in known]),
        ("long numbers among sines", [16, 16], [[list(x), [["9" * 2000]] * 5] for x in known]),
        ("a high degree among sines", [1, 1], [[[0, 0], [["1"]] * 300]]),
        ("high powers of pi among sines", [1, 1], [[[0, 0], [["1"] * 100] * 300]]),
    ):
        factor = {"waves": waves, "terms": terms}
        functions = {
            f"{x}.{part}": {"number": "1", "powers": [[0, 1], [1, -1]]}
            for x in ("environment", "perceived", "difference", "sum", "excess")
            for part in ("real", "imag")
        }
        own = {"delays": ["1/3", "1/7"], "factors": [factor] * 2, "functions": functions}
        yield name, with_proof(**own, breakpoints=["0", *(f"1/{n}" for n in range(1500, 1, -1)), "15"])
    yield "delays without end", with_proof(delays=[f"1/{n}" for n in range(1, 100_000)])
    yield "no delays", with_proof(delays=None)
    yield from _hostile_orders(with_proof)


def _hostile_orders(with_proof: Callable[..., str]) -> Iterator[tuple[str, str]]:
    """The same with powers: of a scene that has none, so that every factor cancels."""
    many = [[list(x), [["1"]]] for x in product(range(17), range(17))]
    curves = ("environment", "perceived", "difference", "sum", "excess")
    functions = {f"{x}.{y}": {"number": "1", "powers": [[0, 1], [1, -1]]} for x in curves for y in ("real", "imag")}
    points = ["0", *(f"1/{n}" for n in range(1500, 1, -1)), "15"]
    for name, orders, terms in (
        ("many powers", ["1/3"], many),
        ("a long order", [f"1/{2**99 + 1}"], many),
        ("an order with a huge denominator", [f"1/{10**1000 + 1}"], many),
        ("an order above 1", [f"{10**9}/7"], many),
        ("high powers of two orders", ["1/3", "1/7"], [[[40, 40, 40, 40], [["1"] * 100] * 300]]),
        ("many orders", [f"1/{n}" for n in range(2, 7)], [[[1] * 10, [["1"]]]]),
        ("orders without end", [f"1/{n}" for n in range(2, 100_000)], many),
    ):
        yield (
            name,
            with_proof(
                orders=orders, factors=[{"waves": [], "terms": terms}] * 2, functions=functions, breakpoints=points
            ),
        )
    yield "no orders", with_proof(orders=None)


CANCELLING = (
    ("300 + s^(1/4)*s^( 3 / 12 )", "300 + s^0.5"), ("300 + s^(4/2) + s^(-1/4)", "300 + s^2 + s^-0.25"),
    ("300 + s^0.5*s^0.5", "300 + s"), ("300 + s^0.5/s^0.5", "301"), ("300 + (s^0.5)^2", "300 + s"), ("300 + (s^-0.25)^(-2)", "300 + s^0.5"),
    ("300 + s^0.3*s^1.7", "300 + s^2"), ("300 - s^0.5*s^0.25/s^2", "300 - s^-1.25"), ("300 + (s^0.5 + s)/s^0.5", "301 + s^0.5"),
    ("300 + (2*s^0.5 + 0 - 3*s^0.5)*s^0.5", "300 - s"), ("300 + s^.2*(s^.3 + 9)*s^.5/s^.7", "300 + s^0.3 + 9"),
    ("300 + 1/(s^0.5*(s + 1) + s^0.5)", "300 + s^-0.5/(s + 2)"), ("300 + (0*s + s^0.5 - 0/s)*s^0.5", "300 + s"),
)  # fmt: skip
"""Formulas in which powers of s cancel, and what is left."""
