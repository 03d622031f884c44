"""What is derived, by laws: leading terms against the distortion itself with devices a million times as fast, groups by their units."""

from __future__ import annotations

import random
from collections.abc import Iterator
from math import factorial, prod
from typing import Annotated, Any

import mpmath
import pytest
from jnds import picked
from refusals import refusal
from regions import margin
from strategies import Seeded
from sympy import Rational, Symbol, cosh, exp, lambdify, sinh

import haptisym as hs
from haptisym.kernel.lattices import Lattice, Piece
from haptisym.kernel.symbols import omega, s
from haptisym.model.catalogue import EFFECTS, Slot, effect
from haptisym.model.jnd import Part
from haptisym.model.jndtables import read_threshold
from haptisym.model.quantities import Dimension
from haptisym.verbs.derive.asymptotics import expansion
from haptisym.verbs.derive.derivation import QUANTITIES, bare, listed_name
from haptisym.verbs.derive.entry import derive
from haptisym.verbs.derive.groups import groups

DEVICES: dict[str, Any] = {
    "a lag": lambda x: hs.effects.first_order_lag(f"{20 / x} rad/s"),
    "a low-pass": lambda x: hs.effects.second_order_lowpass(f"{50 / x} rad/s", "0.7"),
    "a delay": lambda x: hs.effects.delay(f"{Rational(1, 30) * x} s"),
    "a hold": lambda x: hs.effects.zero_order_hold(f"{Rational(1, 40) * x} s"),
    "a Pade delay": lambda x: hs.effects.pade_delay(f"{Rational(1, 20) * x} s", 2),
    "wave variables": lambda x: hs.effects.wave_variables(12, f"{Rational(1, 50) * x} s"),
    "four channels": lambda x: hs.effects.four_channel_teleoperator(1, 2, 30, 2, 40, 50, f"{Rational(1, 60) * x} s"),
}
SLOW = {"a damper": hs.effects.shunt(b=2), "a cable": hs.effects.compliance(900, 3)}


def chained(scene: hs.Scene, at: Any) -> Any:
    """H_perc - H_env, one chain matrix after the other."""
    H = found = lambdify(s, scene.environment.H, "mpmath")(at)
    for x in scene.effects:
        a, b, c, d = (lambdify(s, entry, "mpmath")(at) for entry in x.matrix)
        found = (a * found + b) / (c * found + d)
    return found - H


@pytest.mark.parametrize("order", [0, 1, 3])
def test_what_leading_terms_leave_falls_with_the_next_power_of_how_fast_devices_are(order: int) -> None:
    """With time constants a thousandth and a two-thousandth it is smaller by 2 to that power."""
    pick = random.Random(order)
    for n in range(3):
        names = pick.sample(sorted(DEVICES), 1 + n % 2)
        between = [SLOW["a damper"]] * (n == 1) + [SLOW["a cable"]] * (n == 2)
        made = [
            hs.Scene(
                hs.environments.mass_spring_damper(2, 15, 100),
                (*between[:1], *(DEVICES[x](Rational(1, k)) for x in names)),
            )
            for k in (1, 1000, 2000)
        ]
        found = expansion(made[0], order)
        assert len(found.terms) == order + 1
        with mpmath.workdps(60):
            at, left = mpmath.mpc(0, 3), []
            for scene in made[1:]:
                values = {p.symbol: p.value for p in scene.parameters}
                terms = sum(lambdify(s, x.expression().xreplace(values), "mpmath")(at) for x in found.terms)
                left.append(abs(chained(scene, at) - terms))
            assert left[0] < mpmath.mpf(10) ** (-3 * (order + 1) + 4)
            assert left[1] == 0 or abs(left[0] / left[1] / 2 ** (order + 1) - 1) < 0.02, (names, order)
            parts = [
                lambdify(omega, found.part(x).xreplace({p.symbol: p.value for p in made[1].parameters}), "mpmath")(
                    mpmath.mpf(3)
                )
                for x in Part
            ]
            whole = sum(
                lambdify(s, x.expression().xreplace({p.symbol: p.value for p in made[1].parameters}), "mpmath")(at)
                for x in found.terms
            )
            assert abs(mpmath.mpc(*parts) - whole) < 1e-40


Time = Annotated[Any, Slot(Dimension.TIME)]


def of_time(name: str, form: Any) -> hs.Effect:
    """A device that is fast where its time constant is short: a function of s times that."""

    @effect(name)
    def own(late: Time) -> Any:
        return form(s * late), 0, 0, 1

    return own("5 ms")


@pytest.fixture
def own_models() -> Iterator[None]:
    before = dict(EFFECTS)
    yield
    EFFECTS.clear()
    EFFECTS.update(before)


@pytest.mark.usefixtures("own_models")
def test_leading_terms_of_a_users_own_devices_are_their_taylor_series() -> None:
    """As far as a device divides by its time constant to the fourth; one that is infinite when infinitely fast has none."""
    made: dict[str, tuple[Any, Any]] = {
        "divided": (
            lambda x: (exp(x) - 1 - x - x**2 / 2 - x**3 / 6) * 24 / x**4,
            lambda n: Rational(24, factorial(n + 4)),
        ),
        "arched": (lambda x: 2 * (cosh(x) - 1) / x**2, lambda n: Rational(2 * (n % 2 == 0), factorial(n + 2))),
        "slanted": (lambda x: sinh(x) / x / (1 - 2 * x), lambda n: Rational(2) ** n * (1 + Rational(n > 1, 24))),
        "bent": (lambda x: (3 + x) / (3 - x), lambda n: Rational(2 if n else 1, 3**n)),
    }
    k, order = Symbol("k", real=True), 3
    for name, (form, known) in made.items():
        found = expansion(hs.Scene(hs.environments.mass_spring_damper(k=100), (of_time(name, form),)), order)
        [late] = found.fast
        assert len(found.terms) == order + 1
        for n, term in enumerate(found.terms):
            own = term.expression().xreplace(dict.fromkeys(term.expression().free_symbols - {s, late}, k))
            assert (own - k * (known(n) - int(n == 0)) * (s * late) ** n).expand() == 0, (name, n)
    for name, grows in {"pushing": lambda x: 1 / x + x, "pulling": lambda x: (1 + x**2) / (x + x**2)}.items():
        scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (of_time(name, grows),))
        assert "grows without bound as the effects get faster" in refusal(expansion, scene)


def test_groups_have_no_unit_and_say_which_sign_they_have() -> None:
    """Scaled by other units of mass, length and time each group is what it was; a parameter > 0 makes a group > 0."""
    scene = hs.Scene(
        hs.environments.two_mass("0.5 kg", "4 N*s/m", "200 N/m", "0.3 kg", "1 N*s/m", "120 N/m"),
        (hs.effects.delay("5 ms"), hs.effects.shunt(b="-1 N*s/m"), hs.effects.second_order_lowpass("30 rad/s", "0.5")),
    )
    found = groups(scene)
    sizes = {
        "m1": (1, 0),
        "b1": (1, -1),
        "k1": (1, -2),
        "m2": (1, 0),
        "b2": (1, -1),
        "k2": (1, -2),
        "tau": (0, 1),
        "b": (1, -1),
        "omega_n": (0, -1),
        "zeta": (0, 0),
    }
    assert {p.symbol.name.split("_shunt")[0] for p in scene.parameters} == set(sizes)
    mass, time = Rational(9), Rational(1, 4)
    scale = {
        p.symbol: p.symbol
        * mass ** sizes[p.symbol.name.split("_shunt")[0]][0]
        * time ** sizes[p.symbol.name.split("_shunt")[0]][1]
        for p in scene.parameters
    }
    for group in (found.frequency, *found.groups):
        scaled = group.value.xreplace(scale | {omega: omega / time})
        assert (scaled / group.value).expand() == 1 or (scaled - group.value).expand() == 0
        assert group.symbol.is_positive is (
            None if group.value.has(Symbol("b_shunt", real=True), Symbol("b", real=True)) else True
        )
    assert len(found.groups) == len(scene.parameters) - len(found.units)
    names = {g.symbol.name for g in found.groups}
    assert len(names) == len(found.groups)


def test_an_order_of_a_power_of_s_is_no_group_and_keeps_its_value() -> None:
    found = groups(
        hs.Scene(hs.environments.spring_pot("80 N*s^0.3/m", "0.3", "50 N/m"), (hs.effects.first_order_lag("20 rad/s"),))
    )
    assert {str(x): v for x, v in found.values.items() if str(x) == "alpha"} == {"alpha": Rational(3, 10)}
    assert "alpha" not in {g.symbol.name for g in found.groups}


@pytest.mark.parametrize("place", range(4))
def test_units_that_do_not_fit_in_any_entry_of_a_chain_matrix_are_refused(place: int) -> None:
    """A frequency where a number, a stiffness, a compliance and a number belong; the last entry may be nothing."""
    for others in (["1", "0", "0", "1"], ["1", "k*2", "1/k", "0"]):
        entries = list(others)
        entries[place] = "w"
        scene = hs.Scene(
            hs.environments.mass_spring_damper(m="2 kg", k="100 N/m"),
            (hs.effects.two_port(*entries, parameters={"k": "50 N/m", "w": "3 rad/s"}),),
        )
        with pytest.raises(hs.SceneError, match="its units do not fit together"):
            groups(scene)


def test_every_name_of_a_quantity_is_found_however_it_is_typed() -> None:
    for name in QUANTITIES:
        for typed in (name, name.lower(), name.replace(" ", "_"), f" {name.upper()}! "):
            assert bare(typed) == bare(name)
            assert bare(listed_name(typed) or "") == bare(name)
    assert listed_name("dq") is None
    kept = derive("fu2019", keep=["omega_n", "zeta"])
    assert ({x.name for x in kept.kept}, kept.kept_thresholds) == ({"omega_n", "zeta"}, ())
    assert derive("fu2019", keep="evaluation.jnd").kept_thresholds == (Part.REAL, Part.IMAG)
    assert repr(derive("fu2019", keep=())).endswith(": nothing as symbols>")
    written = derive(hs.Scene(hs.environments.mass_spring_damper(k=100)), keep=()).to_latex()
    assert written == written.rstrip("\n") + "\n"


def test_the_polynomial_of_a_threshold_has_its_zeros_at_the_crossings_with_its_factors_as_often_as_they_count() -> None:
    """r_r = w^2/(w^2 + 400) = c: (1 - c) w^2 - 400 c, and what it is multiplied by has no zero and no sign."""
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(20),), (0, 15), "0.2")
    p = derive(scene, keep=())["p_r"]
    for w, sign in ((0, -1), (9, -1), (10, 0), (11, 1), (400, 1)):
        value = float(p.xreplace({omega: Rational(w)}))
        assert int(value > 0) - int(value < 0) == sign
    other = derive(scene, keep=())["p_i"]  # 20 w > 0.2 (w^2 + 400)
    roots = [20 * (5 / 2 - (21 / 4) ** 0.5), 20 * (5 / 2 + (21 / 4) ** 0.5)]
    for w, sign in (
        (1, -1),
        (roots[0] - 0.01, -1),
        (roots[0] + 0.01, 1),
        (50, 1),
        (roots[1] - 0.01, 1),
        (roots[1] + 0.01, -1),
    ):
        value = float(other.xreplace({omega: Rational(str(w))}))
        assert (value > 0) - (value < 0) == sign


def test_what_is_judged_is_told_by_its_pieces_and_each_piece_by_its_factors() -> None:
    """The largest of the smallest is positive where the JND is exceeded; the product of all factors changes its sign as a piece does."""
    felt, places = hs.environments.mass_spring_damper("0.5", 3, 40), [0.3, 1.1, 2.3, 3.7, 5.2, 7.1, 8.3, 11.9, 14.6]

    for seed in (1, 3, 5, 7, 10):
        jnd = picked(Seeded(seed))
        between = (hs.effects.first_order_lag(9) if seed % 2 else hs.effects.delay("200 ms"),)
        scene = hs.Scene(felt, between, (0, 15), read_threshold(jnd))
        d = derive(scene, keep=())
        signs: dict[Any, list[int]] = {}
        lattices = {own: own.function(d.distortion) for own in d.criteria}
        for name, function in lattices.items():
            for key in function.pieces(name) if isinstance(function, Lattice) else (name,):
                at = lambdify(omega, (d.piece(key) if isinstance(key, Piece) else d.excess(key)).factored(), "math")
                signs[key] = [1 if at(w) > 0 else -1 for w in places]
                factors = [(lambdify(omega, x.ring.expression(x.F), "math"), n) for x, n in d.factors(key)]
                product = [prod(f(w) ** n for f, n in factors) for w in places]
                assert len({x * y > 0 for x, y in zip(signs[key], product, strict=True)}) == 1, (jnd, key)
        for i, w in enumerate(places):
            now = {key: row[i] for key, row in signs.items()}
            H, dH = complex(lambdify(s, felt.H)(1j * w)), complex(chained(scene, 1j * w))
            noticed = max(
                x.sign(name, now.__getitem__) if isinstance(x, Lattice) else now[name] for name, x in lattices.items()
            )
            assert (noticed > 0) is (margin(jnd, H, H + dH, w) > 0), (jnd, w)
