"""Which effects matter: every bound against values computed with other means, and the laws that bounds obey."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import combinations, product
from math import inf, isclose, nextafter, sqrt
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import flint
import mpmath
import pytest
import strategies
from marks import QUICK_SCENES, often
from regions import margin, outside
from sympy import Expr, Integer, Rational, exp, lambdify, pi

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.judge.regions import Sided
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import s
from haptisym.model.catalogue import EFFECTS
from haptisym.model.jnd import Part
from haptisym.model.jndtables import read_threshold
from haptisym.programs.series import series_arithmetic
from haptisym.verbs.effects.ballchain import TERMS, BallChain, BandPiece, Kept
from haptisym.verbs.effects.differences import Difference, SupremumBounds, _down, _Expansion, _up
from haptisym.verbs.effects.enclosing import _reach, levels
from haptisym.verbs.effects.entry import relevance
from haptisym.verbs.effects.relevance import CrossingEnclosure, Relevance
from haptisym.verbs.effects.subsets import SubsetSearch
from haptisym.verbs.effects.suprema import WIDTH
from haptisym.verbs.simulate.entry import simulate

MP = mpmath.MPContext()
MP.dps = 40
MANY = "control-stick-in-detail"
SPRING = hs.environments.mass_spring_damper(k=100)


def test_the_ends_of_an_enclosure_are_the_nearest_floats_that_hold_it() -> None:
    """What a float can say exactly is said so."""
    draw = Random(1)
    for _ in range(60):
        parts = [draw.choice([1, 3, 8, 2**20]) for _ in range(2)]
        low, high = sorted(Rational(draw.randint(1, 10**6), q) for q in parts)
        own = CrossingEnclosure(
            noticed(hs.Scene(SPRING).threshold)[0], ExactNumber(low), ExactNumber(high), certain=True
        )
        down, up = own.bounds
        assert Fraction(down) <= low < Fraction(nextafter(down, inf))
        assert Fraction(nextafter(up, 0)) < high <= Fraction(up)


class Witness:
    """Ratios at 40 digits, from the matrices as they are written, with nothing of the package's algebra."""

    def __init__(self, scene: hs.Scene) -> None:
        self.scene = scene
        rendered = scene.rendered or scene.environment
        self.environment, self.rendered = (function(x.H) for x in (scene.environment, rendered))
        self.matrices = [[function(entry) for entry in effect.matrix] for effect in scene.effects]

    def ratios(self, omega: object, kept: Kept) -> tuple[object, object]:
        at = MP.mpc(0, omega)
        force, position = self.rendered(at), MP.mpf(1)
        for i in sorted(kept):
            a, b, c, d = (entry(at) for entry in self.matrices[i])
            force, position = a * force + b * position, c * force + d * position
        environment = self.environment(at)
        change = (force / position - environment) / abs(environment)
        return abs(change.real), abs(change.imag)

    def changes(self, omega: object, kept: Kept) -> tuple[object, object]:
        full = self.ratios(omega, frozenset(range(len(self.matrices))))
        return tuple(abs(a - b) for a, b in zip(full, self.ratios(omega, kept), strict=True))  # type: ignore[return-value]

    def grid(self, count: int) -> list[object]:
        low, high = (MP.mpf(str(x.evalf(40))) for x in self.scene.band)
        return [low + (high - low) * MP.mpf(2 * i + 1) / (2 * count) for i in range(count)]


def function(entry: Expr, context: mpmath.MPContext = MP) -> object:
    """An entry as a function of s on a context of mpmath of its own."""
    exact = {x: context.mpf(x.p) / x.q for x in entry.atoms(Rational) if not x.is_Integer}
    names = {x: hs.symbols(f"q{i}") for i, x in enumerate(exact)}
    run = lambdify([s, *names.values()], entry.xreplace(names), [
        {"exp": context.exp, "cosh": context.cosh, "sinh": context.sinh, "pi": context.pi, "I": context.j},
    ])  # fmt: skip
    return lambda at: context.mpc(run(at, *exact.values()))


def check(scene: hs.Scene, kept: Kept, count: int = 200) -> None:
    """No sample is above the certified supremum, and the best of them comes close to it."""
    balls, witness = BallChain(scene), Witness(scene)
    grid = witness.grid(count)
    changes = [witness.changes(omega, kept) for omega in grid]
    for i, part in enumerate(hs.Part):
        found = Difference(scene, balls, kept, part).supremum()
        values = [row[i] for row in changes]
        best = max(range(count), key=values.__getitem__)
        assert all(value <= found.most + 1e-30 for value in values), (part, found, float(values[best]))
        assert found.most - found.least <= max(WIDTH * found.most * 1.01, 1e-12)
        if found.most > 1e-9:
            step = (grid[1] - grid[0]) / 2
            near = [grid[best] + step * MP.mpf(k) / 40 for k in range(-39, 40)]
            reached = max(witness.changes(omega, kept)[i] for omega in near)
            assert reached >= found.least * (1 - MP.mpf("0.02")), (part, found, float(reached))


@pytest.mark.slow
@pytest.mark.parametrize("name", often(hs.scene_names(), lambda name: name in QUICK_SCENES))
def test_no_sample_exceeds_a_certified_influence_and_the_best_one_comes_near(name: str) -> None:
    scene = hs.load_scene(name)
    for i in range(len(scene.effects)):
        check(scene, frozenset(range(len(scene.effects))) - {i})


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", often(range(40), lambda seed: seed < 4))
def test_influences_of_random_scenes_hold_between_samples(seed: int) -> None:
    scene = strategies.scene(strategies.case(strategies.Seeded(seed)))
    if any(x.evalf() > 1000 for x in scene.band):
        scene = scene.with_band(scene.band[0], scene.band[0] + 100)
    balls, everything = BallChain(scene), frozenset(range(len(scene.effects)))
    witness = Witness(scene)
    for i in everything:
        for k, part in enumerate(hs.Part):
            found = Difference(scene, balls, everything - {i}, part).supremum()
            values = [witness.changes(omega, everything - {i})[k] for omega in witness.grid(100)]
            assert max(values) <= found.most + 1e-30  # the witness rounds too
            assert found.least <= found.most


def test_a_range_on_a_piece_holds_every_value_on_it() -> None:
    scene = hs.load_scene("sampled-wall")
    balls, witness = BallChain(scene), Witness(scene)
    for piece in (BandPiece(3, 0), BandPiece(3, 5), BandPiece(6, 63)):
        low, high = (MP.mpf(str(x.evalf(40))) for x in balls.ends(piece))
        for i, part in enumerate(hs.Part):
            with series_arithmetic():
                found = Difference(scene, balls, frozenset({1, 2}), part).range(piece)
            for k in range(1, 20):
                value = witness.changes(low + (high - low) * k / 20, frozenset({1, 2}))[i]
                assert found.least <= value <= found.most


@pytest.fixture(scope="module")
def many() -> Relevance:
    return relevance(hs.load_scene(MANY))


def test_two_of_ten_effects_matter_and_the_formula_is_five_times_shorter(many: Relevance) -> None:
    assert (len(many.scene.effects), [e.name for e in many.pruned.effects]) == (10, ["force-loop", "grip"])
    assert many.smallest
    full, kept = many.operations
    assert full >= 5 * kept


@pytest.mark.slow
def test_the_joint_bound_holds_for_all_left_out_effects_together(many: Relevance) -> None:
    kept = frozenset(i for i, e in enumerate(many.scene.effects) if e in many.pruned.effects)
    check(many.scene, kept)
    assert all(x.most <= 0.01 for x in many.bound.values())


def test_every_smaller_set_of_effects_breaks_the_tolerance_somewhere(many: Relevance) -> None:
    witness = Witness(many.scene)
    grid = witness.grid(40)
    for kept in (frozenset(), *(frozenset({i}) for i in range(10))):
        assert any(max(witness.changes(omega, kept)) > 0.01 for omega in grid), kept


@pytest.mark.parametrize("name", [MANY, "helicopter-cyclic", "desktop-device-soft-tissue"])
def test_the_enclosures_hold_all_crossings_of_the_full_scene(name: str) -> None:
    scene = hs.load_scene(name)
    found = relevance(scene, "0.05")
    full = [(c.part, float(c.omega)) for c in hs.evaluate(scene).crossings]
    for part, omega in full:
        assert any(x.part is part and x.bounds[0] <= omega <= x.bounds[1] for x in found.crossings)
    for x in found.crossings:
        inside = [omega for part, omega in full if part is x.part and x.bounds[0] <= omega <= x.bounds[1]]
        assert inside or not x.certain


def test_a_larger_tolerance_keeps_no_more_effects() -> None:
    scene = hs.load_scene("steering-wheel")
    sizes = [len(relevance(scene, t).pruned.effects) for t in ("0", "0.001", "0.03", "0.1", "0.5", "10")]
    assert sizes == sorted(sizes, reverse=True)
    assert (sizes[0], sizes[-1]) == (3, 0)


def test_an_identity_has_no_influence_and_is_left_out_for_any_tolerance() -> None:
    effects = (
        hs.effects.series("(s + 3)/(3 + s)", name="nothing"),
        hs.effects.first_order_lag(20),
        hs.effects.delay(0),
    )
    found = relevance(hs.Scene(SPRING, effects), 0)
    assert [e.name for e in found.pruned.effects] == ["first-order-lag"]
    influences = [{part: x.change[part].most for part in hs.Part} for x in found.effects]
    assert influences[0] == influences[2] == {hs.Part.REAL: 0.0, hs.Part.IMAG: 0.0}


def test_effects_that_make_up_for_each_other_are_left_out_together() -> None:
    mass = (hs.effects.shunt(m="2 kg", name="mass"), hs.effects.shunt(m="-2 kg", name="compensation"))
    found = relevance(hs.Scene(SPRING, (*mass, hs.effects.first_order_lag(20))))
    assert [e.name for e in found.pruned.effects] == ["first-order-lag"]
    assert all(x.change[hs.Part.REAL].least > 1 for x in found.effects[:2])
    assert all(x.most == 0 for x in found.bound.values())


def test_a_change_that_just_reaches_the_tolerance_is_within_it() -> None:
    found = relevance(hs.Scene(SPRING, (hs.effects.series("0.99"),)))
    assert found.pruned.effects == ()
    assert 0.01 <= found.bound[hs.Part.REAL].most < 0.01 * (1 + 1e-6)
    assert len(relevance(hs.Scene(SPRING, (hs.effects.series("0.99"),)), "0.00999999999999").pruned.effects) == 1


def test_an_unbounded_influence_is_told_and_never_left_out_but_a_bounded_difference_of_unbounded_ratios_may_be() -> (
    None
):
    undamped = hs.environments.mass_spring_damper(m=1, k=100)
    scene = hs.Scene(undamped, (hs.effects.second_order_lowpass(900, 1), hs.effects.shunt(b=1)))
    assert hs.evaluate(scene).unbounded  # at the resonance, with the filter and without it
    found = relevance(scene, "0.1")
    assert [[x.change[part].is_finite for part in hs.Part] for x in found.effects] == [[True, True], [True, False]]
    assert [e.name for e in found.pruned.effects] == ["shunt"]
    check(scene, frozenset({1}))
    assert [x["influence"]["imag"] is None for x in found.to_dict()["effects"]] == [False, True]
    assert "unbounded" in str(found)


@pytest.mark.slow
def test_a_bounded_difference_of_ratios_that_are_unbounded_at_omega_0_takes_few_pieces(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    lags = (hs.effects.first_order_lag(20), hs.effects.pade_delay("100 ms", 1), hs.effects.first_order_lag(2))
    scene = hs.Scene(hs.environments.mass_spring_damper(m=2), lags, (0, 2), rendered=hs.environments.kelvin_voigt(9, 1))
    witness, pieces, look = Witness(scene), [], Difference.range
    monkeypatch.setattr(Difference, "range", lambda self, piece: pieces.append(piece) or look(self, piece))
    kept = frozenset({1, 2})
    found = Difference(scene, BallChain(scene), kept, hs.Part.REAL).supremum()
    assert found.most - found.least <= WIDTH * found.most
    assert float(witness.changes(MP.mpf(10) ** -9, kept)[0]) == pytest.approx(found.most, rel=1e-6)
    assert len(pieces) < 2000  # 607; each is a few chains


ELSEWHERE = {
    "a free mass with delay": hs.Scene(
        hs.environments.mass_spring_damper(m=2), (hs.effects.delay("5 ms"), hs.effects.shunt(m="0.1 kg"))
    ),
    "a resonance without damping": hs.Scene(
        hs.environments.mass_spring_damper(m=1, k=49),
        (hs.effects.first_order_lag(20), hs.effects.zero_order_hold("5 ms")),
    ),
    "powers of s from 0 on": hs.Scene(
        hs.environments.spring_pot(k_alpha=50, alpha="0.37"), (hs.effects.first_order_lag(20), hs.effects.delay("5 ms"))
    ),
    "waves on a free mass": hs.Scene(
        hs.environments.mass_spring_damper(m=2), (hs.effects.wave_variables(20, "5 ms"), hs.effects.delay("3 ms"))
    ),
}
"""Where ratios are limits, 0/0 or powers that are not whole."""


@pytest.mark.parametrize("scene", ELSEWHERE.values(), ids=ELSEWHERE)
def test_influences_hold_where_ratios_are_limits(scene: hs.Scene) -> None:
    for i in (0, 1):
        check(scene, frozenset({1 - i}), 60)


def test_units_of_force_do_not_change_influences() -> None:
    case = strategies.case(strategies.Seeded(3))
    ones, others = (relevance(strategies.scene(x)) for x in (case, strategies.scaled(case, force=Fraction(7))))
    assert [x.kept for x in ones.effects] == [x.kept for x in others.effects]
    for a, b in zip(ones.effects, others.effects, strict=True):
        for part in hs.Part:
            assert isclose(a.change[part].most, b.change[part].most, rel_tol=2 * WIDTH, abs_tol=2e-12)


@pytest.mark.parametrize("name", ["sidestick", "zener-tissue"])
def test_where_an_effect_is_said_to_dominate_it_does(name: str) -> None:
    scene = hs.load_scene(name)
    found, witness = relevance(scene), Witness(scene)
    everything = frozenset(range(len(scene.effects)))
    assert len({x.effect.name for x in found.dominance}) == 2
    for x in found.dominance:
        low, high = (MP.mpf(str(end.evalf(40))) for end in (x.low, x.high))
        for k in range(1, 20):
            omega = low + (high - low) * k / 20
            change = [max(witness.changes(omega, everything - {i})) for i in everything]
            assert change.index(max(change)) == scene.effects.index(x.effect)


def test_an_evaluation_with_a_tolerance_is_that_of_the_pruned_scene_and_says_so() -> None:
    found = hs.evaluate(hs.load_scene(MANY), tolerance="0.01")
    told = found.to_dict()["relevance"]
    assert told["kept"] == ["force-loop", "grip"]
    assert told["bound"]["real"] <= 0.01
    assert "Without reconstruction-filter" in str(found)
    assert "gear" not in str(found.distortion.perceived)
    assert "relevance" not in hs.evaluate(hs.load_scene("fu2019")).to_dict()


@pytest.mark.slow
def test_the_document_has_the_agreed_keys(many: Relevance) -> None:
    told = json.loads(json.dumps(many.to_dict()))
    assert told["schema"] == "haptisym.effects/1"
    assert {"tolerance", "effects", "bound", "crossings", "operations"} <= told.keys()
    assert told["tolerance"] == 0.01
    assert set(told["effects"][0]) == {"name", "model", "influence", "kept"}
    assert told["operations"]["full"] >= 5 * told["operations"]["kept"]


@pytest.mark.parametrize("given", ["-1", "nan", "abc", "1 kg", True])
def test_a_tolerance_that_is_none_is_an_error(given: object) -> None:
    with pytest.raises(hs.SceneError, match="tolerance"):
        relevance(hs.load_scene("fu2019"), given)  # type: ignore[arg-type]


def test_symbols_have_no_influence_that_could_be_told() -> None:
    with pytest.raises(hs.SceneError, match="is a symbol"):
        relevance(hs.Scene(hs.environments.mass_spring_damper(k=hs.symbols("k"))))


EXAMPLES: dict[str, dict[str, object]] = {
    "first-order-lag": {"omega_c": 40},
    "second-order-lowpass": {"omega_n": 40, "zeta": 1},
    "delay": {"tau": "5 ms"},
    "pade-delay": {"tau": "5 ms", "order": 2},
    "zero-order-hold": {"T": "5 ms"},
    "sampled-loop": {"T": "5 ms", "method": "backward-difference"},
    "series": {"G": "1/(1 + s*q)", "parameters": {"q": "10 ms"}},
    "shunt": {"b": "3 N*s/m"},
    "compliance": {"k": "5000 N/m"},
    "coulomb-friction": {"force": "0.2 N", "amplitude": "5 cm"},
    "admittance-display": {"P": "q/(s + q)", "parameters": {"q": 90}},
    "wave-variables": {"b": 20, "tau": "5 ms"},
    "position-force-teleoperator": {"Mm": "0.1 kg", "Ms": "0.1 kg", "Bs": 60, "Ks": 4000, "tau": "5 ms"},
    "position-position-teleoperator": {"Mm": "0.1 kg", "Bm": 60, "Km": 900, "Ms": "0.1 kg", "Bs": 60, "Ks": 4000},
    "four-channel-teleoperator": {
        "Mm": "0.1 kg", "Bm": 60, "Km": 900, "Ms": "0.1 kg", "Bs": 60, "Ks": 4000, "tau": "5 ms",
    },
    "two-port": {"A": "1", "B": "q*s", "C": "0", "D": "1", "parameters": {"q": "1 N*s/m"}},
}  # fmt: skip
"""Every effect of the catalogue."""


def test_the_examples_are_the_catalogue() -> None:
    assert EXAMPLES.keys() == EFFECTS.keys()


@pytest.mark.few(4)
@pytest.mark.parametrize("model", EXAMPLES)
def test_nothing_of_an_effect_that_a_scene_does_not_name_appears_anywhere(model: str) -> None:
    effect = EFFECTS[model].build(**EXAMPLES[model], name="guest")
    env = hs.environments.mass_spring_damper(1, 12, 300)
    lag = hs.effects.first_order_lag("8 Hz", name="host")
    both = (effect, lag) if model == "sampled-loop" else (lag, effect)  # which is the first effect of its scene
    with_it, without = hs.Scene(env, both), hs.Scene(env, (lag,))
    guests = {p.symbol for p in with_it.parameters} - {p.symbol for p in without.parameters}
    assert guests
    assert not guests & without.symbolic_distortion().free_symbols
    assert not guests & set(hs.derive(without).steps.free_symbols)
    text = f"{hs.evaluate(without)}{hs.evaluate(without).to_json()}{hs.latex(hs.evaluate(without))}"
    assert "guest" not in text
    assert model not in text or model in ("first-order-lag", "series")  # "effects in series" are words of the page
    run = simulate(without, hs.sine("1 cm", 5), duration="0.5 s")
    assert run.built == ("mass-spring-damper", "first-order-lag")


def test_a_pruned_scene_builds_only_what_is_kept_when_it_is_simulated(many: Relevance) -> None:
    run = simulate(many.pruned, hs.sine("1 cm", 5), duration="0.5 s")
    assert run.built == ("mass-spring-damper", "first-order-lag", "shunt")


@pytest.mark.slow
def test_the_figure_names_every_effect_and_is_the_same_every_time(tmp_path: Path, many: Relevance) -> None:
    first, second = (many.save_figure(tmp_path / name).read_bytes() for name in ("a.pdf", "b.pdf"))
    assert first == second
    text = many.save_figure(tmp_path / "c.svg").read_text(encoding="utf-8")
    assert all(f"<!-- {x.name} -->" in text for x in many.scene.effects)
    with pytest.raises(hs.SceneError, match=r"\.svg, \.pdf or \.png"):
        many.save_figure(tmp_path / "d.gif")


def test_a_scene_without_effects_has_nothing_that_matters() -> None:
    found = relevance(hs.Scene(SPRING))
    assert (found.effects, found.dominance, found.crossings, found.bound[hs.Part.REAL].most) == ((), (), (), 0)
    assert "no effects" in str(found)


# --- chains in ball arithmetic, operation by operation ---------------------------------------------------------------

FINE = mpmath.MPContext()
FINE.dps = 110
NODES, STEP = range(-4, 5), FINE.mpf(10) ** -9
SCALE = FINE.inverse(FINE.matrix([[FINE.mpf(i) ** n for n in range(9)] for i in NODES]))
"""Taylor coefficients of what passes through values at nine places close together: to some 26 digits up to the sixth."""

CHAINS = {
    **ELSEWHERE,
    "a damper alone": hs.Scene(
        hs.environments.mass_spring_damper(b=3), (hs.effects.shunt(m="0.2 kg"), hs.effects.delay("9 ms")), (0, 40)
    ),
    "pi beside whole numbers, and what is rendered is another": hs.Scene(
        hs.environments.mass_spring_damper(2, 9, 150),
        (
            hs.effects.series("(s + a)*(s + b)/(s + 9)^2", parameters={"a": "2 Hz", "b": "7 rad/s"}),
            hs.effects.first_order_lag("8 Hz"),
        ),
        ("0.5 Hz", "3 Hz"),
        rendered=hs.environments.kelvin_voigt(120, 2),
    ),
    "a teleoperator with delay at fractional tissue": hs.Scene(
        hs.environments.spring_pot(k_alpha=50, alpha="0.37", k=20),
        (
            hs.effects.position_force_teleoperator(Mm="0.1 kg", Ms="0.1 kg", Bs=60, Ks=4000, tau="5 ms"),
            hs.effects.compliance(k=3000, b=2),
        ),
        (2, 30),
    ),
    "two resonances without damping": hs.Scene(
        hs.environments.expression("(s^2 + 49)*(s^2 + 121)*s/(s + 5)", parameters={}),
        (hs.effects.first_order_lag(30), hs.effects.zero_order_hold("5 ms"), hs.effects.series("-1.1")),
        (0, 20),
    ),
}


class Wide(Witness):
    """The functions whose smaller modulus is a change, (a - b)/|H_env| and (a + b)/|H_env| for each part, as Taylor series."""

    def __init__(self, scene: hs.Scene) -> None:
        super().__init__(scene)
        rendered = scene.rendered or scene.environment
        self.environment, self.rendered = (function(x.H, FINE) for x in (scene.environment, rendered))
        self.matrices = [[function(entry, FINE) for entry in effect.matrix] for effect in scene.effects]

    def complex_ratio(self, omega: object, kept: Kept) -> object:
        at, force, position = FINE.mpc(0, omega), self.rendered(FINE.mpc(0, omega)), FINE.mpf(1)
        for i in sorted(kept):
            a, b, c, d = (entry(at) for entry in self.matrices[i])
            force, position = a * force + b * position, c * force + d * position
        felt = self.environment(at)
        return (force / position - felt) / abs(felt)

    def pairs(self, omega: object, kept: Kept) -> dict[hs.Part, tuple[object, object]]:
        full, some = (self.complex_ratio(omega, x) for x in (frozenset(range(len(self.matrices))), kept))
        minus, plus = full - some, full + some
        return {hs.Part.REAL: (minus.real, plus.real), hs.Part.IMAG: (minus.imag, plus.imag)}

    def series(self, omega: object, kept: Kept) -> dict[hs.Part, list[list[object]]]:
        """Per part the coefficients of both functions in the distance from a frequency, constant first."""
        rows = [self.pairs(omega + i * STEP, kept) for i in NODES]
        values = {p: [FINE.matrix([row[p][k] for row in rows]) for k in (0, 1)] for p in hs.Part}
        return {p: [[x / STEP**n for n, x in enumerate(SCALE * column)] for column in values[p]] for p in hs.Part}


def turned(series: tuple[object, object], exact: list[list[object]]) -> list[list[object]]:
    """Both exact series, with both signs turned where those that were found are turned: over zeros of H_env they are."""
    aligned = sum(exactly(x[0].mid()) * own[0] for x, own in zip(series, exact, strict=True))  # type: ignore[index]
    return exact if aligned > 0 else [[-x for x in own] for own in exact]


def exactly(x: object) -> object:
    """The number of a flint ball's middle or radius at many digits."""
    mantissa, exponent = x.man_exp()  # type: ignore[attr-defined]
    return FINE.mpf(int(mantissa)) * FINE.mpf(2) ** int(exponent)


def distance(ball: object, value: object) -> object:
    """How far a number lies outside of a ball; negative inside."""
    return abs(exactly(ball.mid()) - value) - exactly(ball.rad())  # type: ignore[attr-defined]


def frequency(balls: BallChain, piece: BandPiece, share: object) -> object:
    low, high = (FINE.mpf(str(x.evalf(60))) for x in balls.ends(piece))
    return low + (high - low) * share


def turned_over(kept: Kept, count: int) -> list[Kept]:
    return [kept, frozenset(range(count)) - kept]


@pytest.mark.parametrize("scene", CHAINS.values(), ids=CHAINS)
def test_series_in_the_middle_of_a_piece_are_the_taylor_series_of_the_changes(scene: hs.Scene) -> None:
    balls, witness = BallChain(scene), Wide(scene)
    for piece, kept in (
        (BandPiece(), frozenset({0})),
        (BandPiece(2, 1), frozenset()),
        (BandPiece(9, 400), frozenset({1})),
    ):
        expected = witness.series(frequency(balls, piece, FINE.mpf(1) / 2), kept)
        with series_arithmetic():
            for part in hs.Part:
                pair = balls.changes(piece, kept, part, whole=False)
                for series, exact in zip(pair, turned(pair, expected[part]), strict=True):
                    size = max(abs(x) for x in exact[:TERMS]) + FINE.mpf(10) ** -9
                    for n in range(TERMS):
                        assert abs(exactly(series[n].mid()) - exact[n]) < size * FINE.mpf(10) ** -14
                        assert distance(series[n], exact[n]) < size * FINE.mpf(10) ** -22
                        assert exactly(series[n].rad()) < size * FINE.mpf(10) ** -18


@pytest.mark.slow
@pytest.mark.parametrize("scene", CHAINS.values(), ids=CHAINS)
def test_series_over_a_whole_piece_hold_the_taylor_series_of_every_place_in_it_and_narrow_with_it(
    scene: hs.Scene,
) -> None:
    """Also on pieces with a zero of H_env: at 0, or inside. Only fractional powers have no series at 0."""
    balls, witness = BallChain(scene), Wide(scene)
    at_seven = int((7 - float(balls.low)) / float(balls.width) * 4096)
    rough = "powers" in next(name for name, x in CHAINS.items() if x is scene)
    for piece in (BandPiece(12, 0), BandPiece(12, at_seven), BandPiece(12, 4095), BandPiece(7, 5)):
        kept = frozenset({piece.place % 2})
        shares = [FINE.mpf(x) for x in ("0.0001", "0.4", "0.9999")]
        exact = [witness.series(frequency(balls, piece, share), kept) for share in shares]
        with series_arithmetic():
            for part in hs.Part:
                pair = balls.changes(piece, kept, part, whole=True)
                if rough and piece.place == 0:
                    assert not any(x[0].is_finite() for x in pair)
                    continue
                deeper = balls.changes(BandPiece(piece.depth + 4, piece.place << 4), kept, part, whole=True)
                for k, series in enumerate(pair):
                    own = [turned(pair, x[part])[k] for x in exact]
                    for n in range(TERMS + 1):
                        slack = max(abs(x[n]) for x in own) * FINE.mpf(10) ** -15 + FINE.mpf(10) ** -18
                        assert all(distance(series[n], x[n]) < slack for x in own)
                        assert exactly(deeper[k][n].rad()) < exactly(series[n].rad()) / 8 + FINE.mpf(10) ** -8


@pytest.mark.few(1)
@pytest.mark.parametrize("scene", CHAINS.values(), ids=CHAINS)
def test_ranges_on_pieces_hold_all_values_and_are_reached(scene: hs.Scene) -> None:
    balls, witness = BallChain(scene), Wide(scene)
    for piece in (BandPiece(), BandPiece(3, 6), BandPiece(9, 300), BandPiece(12, 0), BandPiece(12, 4095)):
        kept = frozenset({piece.depth % 2})
        ends = (FINE.mpf(10) ** -12, FINE.mpf("0.5"), 1 - FINE.mpf(10) ** -12)
        shares = [*ends, *(FINE.mpf(i) / 16 for i in range(1, 16))]
        rows = [witness.pairs(frequency(balls, piece, x), kept) for x in shares]
        for part in hs.Part:
            with series_arithmetic():
                found = Difference(scene, balls, kept, part).range(piece)
                middle = Difference(scene, balls, kept, part).at_middle(piece)
            values = [min(map(abs, row[part])) for row in rows]
            assert found.least <= min(values) * (1 + FINE.mpf(10) ** -15)
            assert max(values) <= found.most
            assert middle <= values[1] <= middle * (1 + 1e-14) + 1e-24
            if found.most < inf:
                assert found.reached <= max(values) * (1 + FINE.mpf(10) ** -8)
            if piece.depth >= 9 and found.most < inf:
                spread, rounding = max(values) - min(values), 1e-13 * max(values) + 1e-20
                assert found.most <= max(values) + spread + rounding
                assert found.least >= min(values) - spread - rounding
                assert found.reached == pytest.approx(float(max(values[:3])), rel=1e-6, abs=1e-15)


def test_precision_and_length_of_series_are_set_for_the_block_alone() -> None:
    length, bits = flint.ctx.cap, flint.ctx.prec
    try:
        flint.ctx.cap, flint.ctx.prec = 3, 77
        with series_arithmetic():
            assert (flint.acb_series([1, 1], prec=20) ** 12)[12] == 1
            assert flint.ctx.prec > 90
        assert (flint.ctx.cap, flint.ctx.prec) == (3, 77)
        with pytest.raises(RuntimeError), series_arithmetic():
            raise RuntimeError
        assert (flint.ctx.cap, flint.ctx.prec) == (3, 77)
    finally:
        flint.ctx.cap, flint.ctx.prec = length, bits


def test_pieces_tile_the_band() -> None:
    balls = BallChain(CHAINS["a teleoperator with delay at fractional tissue"])
    assert balls.ends(BandPiece()) == (2, 30)
    for piece in (BandPiece(), BandPiece(1, 1), BandPiece(5, 11)):
        first, second = piece.halves()
        (low, high), (a, b), (x, y) = (balls.ends(p) for p in (piece, first, second))
        assert (a, b, y) == (low, x, high)
        assert b - a == y - x > 0
        with series_arithmetic():
            assert balls.middle(piece).overlaps(flint.arb(flint.fmpq(int((low + high).p), int((low + high).q))) / 2)
            assert float(balls.radius(piece)) == float(high - low) / 2
            assert balls.radius(piece).is_exact()
    third = BallChain(hs.Scene(SPRING, (), (0, Rational(1, 3))))
    with series_arithmetic():
        assert third.radius(BandPiece()) > flint.arb(flint.fmpq(1, 6))  # rounded up, as it is no binary number


# --- suprema that are known in closed form ---------------------------------------------------------------------------


def change(scene: hs.Scene, kept: set[int], part: hs.Part) -> Difference:
    return Difference(scene, BallChain(scene), frozenset(kept), part)


LAG = hs.effects.first_order_lag(10)
FREE = hs.environments.mass_spring_damper(m=2)
KNOWN = {
    # behind a lag x^2/(1 + x^2) and x/(1 + x^2), x = omega/10
    "a lag to its corner and beyond": (hs.Scene(SPRING, (LAG,), (0, 20)), 0.8, 0.5),
    "a lag below its corner": (hs.Scene(SPRING, (LAG,), (0, 5)), 0.2, 0.4),
    # 1 - cos and sin
    "a delay for half a turn": (hs.Scene(SPRING, (hs.effects.delay("0.1"),), (0, 35)), 2.0, 1.0),
    # |k - m omega^2| and |b omega| over k
    "a device": (hs.Scene(SPRING, (hs.effects.shunt(m=1, b=3),), (0, 15)), 2.25, 0.45),
    "a mass on a mass": (hs.Scene(FREE, (hs.effects.shunt(m="-0.5"),), (0, 15)), 0.25, 0.0),
    "a damper on a mass, away from 0": (hs.Scene(FREE, (hs.effects.shunt(b=3),), (2, 15)), 0.0, 0.75),
    # j (-j x)/(1 + j x) = (x - j x^2)/(1 + x^2) with x = 3 omega/60
    "a compliance on a damper": (
        hs.Scene(hs.environments.mass_spring_damper(b=3), (hs.effects.compliance(k=60),), (0, 40)), 0.5, 0.8,
    ),
    "no effect": (hs.Scene(SPRING, (hs.effects.series("1"),), (0, 40)), 0.0, 0.0),
}  # fmt: skip


@pytest.mark.parametrize(("scene", "real", "imag"), KNOWN.values(), ids=KNOWN)
def test_the_largest_change_of_one_effect_is_the_one_known_in_closed_form(
    scene: hs.Scene, real: float, imag: float
) -> None:
    for part, exact in ((hs.Part.REAL, real), (hs.Part.IMAG, imag)):
        found = change(scene, set(), part).supremum()
        assert found.least <= exact <= found.most
        assert found.most - found.least <= max(1.01e-6 * exact, 1e-12)


@pytest.mark.parametrize("name", [x for x in KNOWN if "delay" not in x and x != "no effect"])
def test_by_the_exact_functions_a_change_lies_between_0_and_a_float_just_above_the_largest(name: str) -> None:
    """And in two halves of the band the larger of both is that of all of it."""
    scene, *expected = KNOWN[name]
    for part, value in zip(hs.Part, expected, strict=True):
        own = change(scene, set(), part)
        rows = [own._exact_bounds(x) for x in (BandPiece(), *BandPiece().halves())]
        assert [low for low, _ in rows] == [0.0] * 3
        for most in (rows[0][1], max(high for _, high in rows[1:])):
            assert value <= most <= value * (1 + 1e-15) + 1e-300


def test_a_change_is_that_of_the_modulus_not_of_the_part() -> None:
    """Springs of +30 and -40 N/m on one of 100: r_r is 0.1 with both and 0.3 with the first, though dH goes from 30 to -10."""
    scene = hs.Scene(SPRING, (hs.effects.shunt(k=30), hs.effects.shunt(k=-40)))
    for kept, exact in (({0}, 0.2), ({1}, 0.3), (set(), 0.1)):
        found = change(scene, kept, hs.Part.REAL).supremum()
        assert found.least <= exact <= found.most < exact * (1 + 1e-5)


def test_whether_a_change_stays_within_a_number_is_decided_exactly_where_it_just_does() -> None:
    lag = change(hs.Scene(SPRING, (LAG,), (0, 20)), set(), hs.Part.IMAG)
    tiny = Rational(1, 10**40)
    assert [lag.stays_within(Rational(1, 2) + x) for x in (-tiny, 0, tiny)] == [False, True, True]
    both = hs.Scene(SPRING, (hs.effects.shunt(k=30), hs.effects.shunt(k=-40)))
    assert [change(both, {0}, hs.Part.REAL).stays_within(Rational(1, 5) + x) for x in (-tiny, 0)] == [False, True]


def resonances(first: str, second: str, top: int = 15) -> hs.Scene:
    """With its second effect of one value at the first resonance and of the opposite one at the second.

    So a - b is bounded at the one and a + b at the other, and the change, the smaller of both, everywhere.
    """
    p, q = Rational(first) ** 2, Rational(second) ** 2
    poles = f"({p}*{q})/((s^2 + {p})*(s^2 + {q}))"
    return hs.Scene(
        SPRING,
        (hs.effects.series(poles), hs.effects.series(f"1 + 2*(s^2 + {p})/({q} - {p})")),
        (0, top),
    )


def test_a_change_with_poles_of_each_of_its_functions_but_none_of_both_is_bounded() -> None:
    scene = resonances("3", "3.01")
    found = change(scene, {0}, hs.Part.REAL).supremum()
    witness, grid = Witness(scene), [MP.mpf(n) / 4000 for n in range(12000, 12041)]
    values = [witness.changes(omega + MP.mpf(10) ** -20, frozenset({0}))[0] for omega in grid]
    assert max(values) <= found.most < inf
    assert max(values) > found.least * MP.mpf("0.99")
    assert found.most - found.least <= 1.01e-6 * found.most


def test_two_poles_too_near_each_other_to_be_told_apart_are_said_to_be_undecided() -> None:
    with pytest.raises(hs.UndecidedError, match=r"bounded near (3\.0000|2\.9999)"):
        change(resonances("3", "3.000000001"), {0}, hs.Part.REAL).supremum()


def test_a_common_pole_makes_a_change_unbounded_wherever_it_lies() -> None:
    scene = hs.Scene(SPRING, (hs.effects.series("9/(s^2 + 9)"), hs.effects.shunt(m=1, b=2)), (0, 15))
    assert change(scene, set(), hs.Part.REAL).supremum().least == inf
    alone = change(scene, {0}, hs.Part.IMAG).supremum()  # the damper's own ratio: no pole
    assert alone.least <= 0.3 <= alone.most < 0.3001


# --- choices ---------------------------------------------------------------------------------------------------------


def gains(*values: str) -> hs.Scene:
    return hs.Scene(SPRING, tuple(hs.effects.series(x, name=f"g{i}") for i, x in enumerate(values)), (0, 15))


def names(found: Relevance) -> list[str]:
    return [e.name for e in found.pruned.effects]


def test_of_several_sets_of_one_size_the_one_with_the_lowest_bound_is_kept() -> None:
    """1.2 * 1.003 * 0.999 is 0.2024: with the first 0.2, with the others 0.003 and 0.001 off 1."""
    found = relevance(gains("1.2", "1.003", "0.999"), "0.01")
    assert (names(found), found.smallest) == (["g0"], True)
    found = relevance(gains("1.2", "1.003", "0.99"), "0.013")
    assert names(found) == ["g0"]
    bound, exact = found.bound[hs.Part.REAL], Rational("1.2") * (1 - Rational("1.003") * Rational("0.99"))
    assert bound.least <= exact <= bound.most
    both = relevance(gains("1.05", "1.04", "1.03"), "0.09")  # the product is 1.12476
    assert names(both) == ["g0"]  # each of them alone does: they leave 0.075, 0.085 and 0.095 aside
    assert both.bound[hs.Part.REAL].most == pytest.approx(0.07476, rel=1e-4)


def test_a_change_above_the_tolerance_at_one_frequency_alone_keeps_an_effect() -> None:
    """1/2 at the corner of a lag, which just is, or is not, within the tolerance; samples never meet it."""
    scene = hs.Scene(SPRING, (LAG,), (0, 11), hs.Threshold.of(5, 5))
    kept = [names(relevance(scene, x)) for x in ("0.54", "0.55", "0.5476")]  # r_r is 121/221 at the end of the band
    assert kept == [["first-order-lag"], [], []]
    imag = hs.Scene(
        hs.environments.mass_spring_damper(b=3), (hs.effects.shunt(k=10),), (2, 15)
    )  # r_i = 0, r_r = 10/(3 omega)
    ends = [names(relevance(imag, x)) for x in (Rational(5, 3), Rational(5, 3) - Rational(1, 10**30))]
    assert ends == [[], ["shunt"]]


def test_a_bound_is_never_told_above_the_tolerance_that_it_is_proven_to_keep() -> None:
    for limit in (Rational(1, 100), Rational(1, 3), Rational(5, 3)):
        found = relevance(hs.Scene(SPRING, (hs.effects.series(str(1 - limit)),)), limit)
        assert names(found) == []
        bound = found.bound[hs.Part.REAL]
        assert Rational(*bound.most.as_integer_ratio()) >= limit
        assert bound.most <= nextafter(nextafter(float(limit), inf), inf)


def test_of_many_effects_a_small_set_is_found_if_not_surely_the_smallest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of five effects all sets of up to two are gone through, as for four all are; then they are left out one by one."""
    monkeypatch.setattr("haptisym.verbs.effects.subsets._MOST_SUBSETS", 16)
    values = ["1.5", "0.5", "1.3", "1.001", "1.002"]
    found = relevance(gains(*values), "0.01")
    assert (names(found), found.smallest) == (["g0", "g1", "g2"], False)
    exact = Rational("1.5") * Rational("0.5") * Rational("1.3") * (Rational("1.001") * Rational("1.002") - 1)
    bound = found.bound[hs.Part.REAL]
    assert bound.least <= exact <= bound.most < 1.00001 * exact
    for others in (["1.5", "0.5", "1.001", "1.002"], ["1.5", "0.5", "1.001", "1.002", "1.0005"]):
        found = relevance(gains(*others), "0.01")
        assert (names(found), found.smallest) == (["g0", "g1"], True)


def test_sampled_ratios_are_those_of_the_matrices() -> None:
    for scene in CHAINS.values():
        balls, witness = BallChain(scene), Wide(scene)
        search = SubsetSearch(scene, balls, Rational(1, 100))
        for kept in (frozenset({0}), frozenset({1}), frozenset()):
            ratios = search._samples.ratios(kept)
            for index in (0, 50, 127):
                exact = witness.complex_ratio(frequency(balls, BandPiece(7, index), FINE.mpf("0.5")), kept)
                assert ratios[:, index] == pytest.approx(
                    [float(abs(exact.real)), float(abs(exact.imag))], rel=1e-9, abs=1e-12
                )
            change, part, piece = search._sampled(kept)
            with series_arithmetic():
                assert Difference(scene, balls, kept, part).at_middle(piece) == pytest.approx(
                    change, rel=1e-7, abs=1e-10
                )
            at = witness.pairs(frequency(balls, BandPiece(7, 64), FINE.mpf("0.5")), kept)
            assert all(min(map(abs, x)) <= change * (1 + 1e-9) + 1e-10 for x in at.values())


# --- crossings of the full scene -------------------------------------------------------------------------------------


def test_crossings_lie_between_those_of_both_levels() -> None:
    """Behind a lag r_i = x/(1 + x^2); a gain of 1.02 after it adds 0.02 at most, so the levels are 0.1 -+ 0.02 and a bit."""
    scene = hs.Scene(SPRING, (LAG, hs.effects.series("1.02", name="gain")), (0, 5))
    found = relevance(scene, "0.03")
    assert names(found) == ["first-order-lag"]
    [imag] = [x for x in found.crossings if x.part is hs.Part.IMAG]
    bound = found.bound[hs.Part.IMAG].most
    ends = [10 * (1 - sqrt(1 - 4 * c * c)) / (2 * c) for c in (0.1 - bound, 0.1 + bound)]
    assert [float(imag.low), float(imag.high)] == pytest.approx(ends, rel=1e-12)
    assert imag.certain
    low, high = imag.bounds
    assert Fraction(low) <= imag.low.bounds(200)[0]
    assert imag.high.bounds(200)[1] <= Fraction(high)
    assert (nextafter(low, inf), nextafter(high, 0)) != (low, high)
    assert high - low < (ends[1] - ends[0]) * (1 + 1e-12)
    assert [x.part for x in found.crossings] == [hs.Part.IMAG, hs.Part.REAL]  # in ascending order


@pytest.mark.parametrize(
    ("gain", "left"), [("-1", True), ("1.05", False), ("1.12", True), ("0.88", False), ("0.7", True)]
)
def test_a_part_that_turned_round_has_left_limits_for_growing_and_shrinking_alike(gain: str, *, left: bool) -> None:
    """Behind a gain g alone x = g - 1, known to 0.01: with -1 it is as large as before, but twice that away, beyond either."""
    sided = Sided(hs.Part.REAL, higher=Rational("0.1"), lower=Rational("0.2"))
    scene = hs.Scene(SPRING, (hs.effects.series(gain),), (0, 5))
    found = levels(sided, scene.distortion(), dict.fromkeys(hs.Part, Rational("0.01")), scene.band)
    sign = found.must.sign("must", lambda x: 1 if found.must.terms[x.term][x.place].ball(flint.arb(2)) > 0 else -1)
    assert sign == (1 if left else -1)


@pytest.mark.parametrize("seed", range(4))
def test_what_must_and_may_be_left_is_so_for_every_change_within_the_bounds(seed: int) -> None:
    """Behind a gain g the spring's real part is g k; with what was left out it is (g + d) k, |d| <= e, for any such d."""
    pick = Random(seed)
    for _ in range(30):
        around, most = pick.choice(
            [(20, 20), (-20, 2)]
        )  # beside -1 whether it has grown is not known, and limits of 2 matter
        g, e = (
            Rational(around + pick.randint(-most, most), 20),
            Rational(pick.choice([1, 2 * 10**7, 10**8, 10**8]), 10**9),
        )
        higher, lower = (Rational(pick.randint(35, 43) if around < 0 else pick.randint(1, 20), 20) for _ in range(2))
        floor = pick.choice([None, None, None, Rational(pick.randint(1, 220))])
        sided = Sided(hs.Part.REAL, higher, pick.choice([higher, lower]), floor)
        scene = hs.Scene(SPRING, (hs.effects.series(g),), (0, 5))
        size = 100
        jnd: dict[str, Any] = {"real": {"higher": str(higher), "lower": str(sided.lower)}, "imag": "1000"}
        jnd |= {} if floor is None else {"floor": str(floor)}
        noticed = [margin(jnd, size, size * float(g + e * d / 8), 1.0) for d in range(-8, 9)]
        found = levels(sided, scene.distortion(), dict.fromkeys(hs.Part, e), scene.band)

        def sign(level: Any) -> int:
            return int(level.sign("x", lambda x: 1 if level.terms[x.term][x.place].ball(flint.arb(2)) > 0 else -1))

        if sign(found.must) > 0:
            assert min(noticed) > 0
        if found.may is not None and sign(found.may) < 0:
            assert max(noticed) <= 1e-12
        if e < Rational(1, 10**8) and min(map(abs, noticed)) > 1e-3:
            assert found.may is not None
            assert sign(found.must) == sign(found.may) == (1 if noticed[0] > 0 else -1)


SHAPES: list[dict[str, Any]] = [
    {"shape": "ellipse", "real": "0.1", "imag": "0.3"},
    {"shape": "ellipse", "real": "0.2", "imag": "0.1", "tilt": "0.8"},
    {"shape": "ellipse", "real": "0.2", "imag": "0.1", "tilt": "-0.6"},
    {"shape": "diamond", "real": "0.1", "imag": "0.25"},
    {"shape": "polygon", "corners": [["0.1", "-0.1"], ["0.1", "0.3"], ["-0.2", "0.1"]]},
]


@pytest.mark.parametrize("jnd", SHAPES)
@pytest.mark.parametrize(("e", "f"), [("1/100", "1/50"), ("3/10", "1/1000"), ("1/1000", "1/5")])
def test_a_region_enlarged_by_the_reach_of_changes_holds_them_all_and_hardly_more(
    jnd: dict[str, Any], e: str, f: str
) -> None:
    [criterion] = noticed(read_threshold(jnd))
    change = {hs.Part.REAL: Rational(e), hs.Part.IMAG: Rational(f)}
    reach = float(_reach(criterion.joint, change, (Rational(0), Rational(5))))  # type: ignore[arg-type]
    a, b = float(Rational(e)), float(Rational(f))
    square = [(x * a, y * b) for x in (-1, -0.3, 0.4, 1) for y in (-1, -0.5, 0.2, 1)]
    assert max(outside(jnd, x / reach, y / reach, 1) for x, y in square) <= 1e-12
    less = reach / (sqrt(2 / (1 - float(jnd.get("tilt", 0)) ** 2)) if jnd["shape"] == "ellipse" else 1.4) * 0.999
    assert max(outside(jnd, x / less, y / less, 1) for x, y in square) > 0


def test_with_a_tolerance_above_the_threshold_crossings_may_lie_anywhere_below_the_upper_level() -> None:
    """A change of up to 0.2 beside a threshold of 0.1: where the kept ratio is below 0.3 nothing is known."""
    scene = hs.Scene(SPRING, (LAG, hs.effects.series("1.2", name="gain")), (0, 40))
    found = relevance(scene, "0.3")
    assert names(found) == ["first-order-lag"]
    for part in hs.Part:
        [*own] = [x for x in found.crossings if x.part is part]
        assert not any(x.certain for x in own)
        assert all(
            any(x.bounds[0] <= float(c.omega) <= x.bounds[1] for x in own)
            for c in hs.evaluate(scene).crossings if c.part is part
        )  # fmt: skip
    bound = found.bound[hs.Part.REAL].most
    [real] = [x for x in found.crossings if x.part is hs.Part.REAL]
    c = 0.1 + bound
    assert (float(real.low), float(real.high)) == (0, pytest.approx(10 * sqrt(c / (1 - c)), rel=1e-12))
    [exact] = relevance(
        hs.Scene(SPRING, (hs.effects.series("1.1"),), (0, 40)), "0.1"
    ).crossings  # that is the threshold
    assert (exact.part, float(exact.low), float(exact.high), exact.certain) == (hs.Part.REAL, 0, 40, False)


def test_an_interval_whose_ratio_returns_to_the_same_side_is_not_certain() -> None:
    """r_i of a lag, at most 1/2 at 10 rad/s: levels 0.46 and 0.54 around the threshold 0.5, of which only the lower is met."""
    effects = (LAG, hs.effects.series("1.04", name="gain"))
    found = relevance(hs.Scene(SPRING, effects, (0, 40), hs.Threshold.of(5, "0.5")), "0.05")
    assert names(found) == ["first-order-lag"]
    [peak] = found.crossings
    assert (peak.part, peak.certain) == (hs.Part.IMAG, False)
    assert float(peak.low) < 10 < float(peak.high)
    lower = relevance(hs.Scene(SPRING, effects, (0, 40), hs.Threshold.of(5, "0.4")), "0.05")
    assert [x.certain for x in lower.crossings] == [True, True]
    assert [float(x.low) < w < float(x.high) for x, w in zip(lower.crossings, (5.0, 20.0), strict=True)] == [True, True]
    cut = relevance(hs.Scene(SPRING, effects, (5, 20), hs.Threshold.of(5, "0.4")), "0.05")
    assert [x.certain for x in cut.crossings] == [False, False]  # they reach the ends of the band
    assert [float(cut.crossings[0].low), float(cut.crossings[1].high)] == [5, 20]


def test_one_effect_dominates_up_to_where_another_one_changes_as_much() -> None:
    """A spring of 20 N/m and a damper of 4 N s/m on 100 N/m: 0.2 and 0.04 omega, alike at 5 rad/s."""
    scene = hs.Scene(SPRING, (hs.effects.shunt(k=20, name="spring"), hs.effects.shunt(b=4, name="damper")), (0, 20))
    first, second = relevance(scene).dominance
    assert (first.effect.name, first.low, second.effect.name, second.high) == ("spring", 0, "damper", 20)
    assert 5 - Rational(20, 1000) <= first.high <= 5 <= second.low <= 5 + Rational(20, 1000)
    [alone] = relevance(hs.Scene(SPRING, (LAG,), (1, 20))).dominance
    assert (alone.low, alone.high) == (1, 20)


@pytest.mark.parametrize(("given", "words"), [("-0.01", ">= 0"), ("1 kg", "tolerance"), ("much", "tolerance")])
def test_a_tolerance_that_is_none_is_refused(given: str, words: str) -> None:
    with pytest.raises(hs.SceneError, match=words):
        relevance(hs.load_scene("fu2019"), given)


def test_an_open_parameter_is_refused_by_name() -> None:
    with pytest.raises(hs.SceneError, match="omega_c = w is a symbol"):
        relevance(hs.Scene(SPRING, (hs.effects.first_order_lag(hs.symbols("w")),)))


# --- decisions -------------------------------------------------------------------------------------------------------


def test_an_expansion_bounds_the_absolute_value_of_every_polynomial_with_such_coefficients() -> None:
    """Against exact fractions: the constant less, and plus, the most that the other terms can be."""
    random = Random(8)
    with series_arithmetic():
        for _ in range(300):
            exact = [
                Fraction(random.randint(-(10**16), 10**16), 10 ** random.randint(14, 19)) for _ in range(TERMS + 1)
            ]
            h = Fraction(random.randint(1, 10**9), 10**10)
            terms = [flint.arb(flint.fmpq(x.numerator, x.denominator)) for x in exact]
            wide = flint.arb_series([flint.arb(0, 10**6)] * (TERMS + 1), prec=TERMS + 1)
            tail = flint.arb_series([*([flint.arb(0, 10**6)] * TERMS), terms[-1]], prec=TERMS + 1)
            radius = flint.arb(flint.fmpq(h.numerator, h.denominator))
            found = _Expansion(flint.arb_series(terms[:TERMS], prec=TERMS), tail, radius)
            spread = sum(abs(x) * h**n for n, x in enumerate(exact) if n)
            least, most = max(abs(exact[0]) - spread, Fraction(0)), abs(exact[0]) + spread
            assert Fraction(found.least) <= least <= found.least * (1 + 1e-12) + 1e-14
            assert Fraction(found.most) >= most >= found.most * (1 - 1e-12)
            ends = [abs(sum(x * t**n for n, x in enumerate(exact))) for t in (0, -h, h)]
            for value, end in zip(found.values, ends, strict=True):
                assert 0 <= Fraction(value) <= end + Fraction(1, 10**7)
                assert float(end) == pytest.approx(value, rel=1e-6, abs=1e-8)
            assert _Expansion(flint.arb_series(terms[:TERMS], prec=TERMS), wide, radius).most <= 10**6 * (1 + 1e-12)
    for x in (flint.arb("0.1"), flint.arb(3), flint.arb(0, 1), flint.arb("1e-300")):
        assert _down(x) <= x.abs_lower() <= x.abs_upper() <= _up(x)
    assert (_up(flint.arb(2)) > 2, _down(flint.arb(2)) < 2, _down(flint.arb(0, 1))) == (True, True, 0.0)
    assert (_up(flint.arb.nan()), _down(flint.arb.nan())) == (inf, 0.0)


def test_the_order_of_a_zero_at_0_counts_delays_as_what_they_are() -> None:
    """sT - (1 - exp(-sT)) and products of 1 - exp(-sT) with delays that have no common measure."""
    effects = (hs.effects.zero_order_hold("5 ms"), hs.effects.zero_order_hold(pi / 1000), hs.effects.first_order_lag(9))
    ring = hs.Scene(SPRING, effects).distortion().chain.ring
    e, f = exp(-s / 200), exp(-s * pi / 1000)
    for form, order in (
        (1 - e, 1), (1 - f, 1), (e - f, 1), (s, 1), (s * (1 - e) ** 2, 3), (s / 200 - (1 - e), 2), (s + 1, 0), (e, 0),
        ((1 - e) * (1 - f), 2), ((1 - e) * pi / 1000 - (1 - f) / 200, 2), (1 - e * f, 1), (s**4, 4), (s - s, inf),
    ):  # fmt: skip
        assert ring.order_at_0(ring.convert(form).numerator) == order, form


def test_what_stays_undecided_is_never_said_to_stay_within(monkeypatch: pytest.MonkeyPatch) -> None:
    lag = change(hs.Scene(SPRING, (LAG,), (0, 20)), set(), hs.Part.IMAG)
    for undecided, exceeds, said in (((), (), True), ((1,), (), None), ((), (1,), False), ((1,), (1,), False)):
        table = SimpleNamespace(undecided=undecided, where=lambda _, own=exceeds: list(own))
        monkeypatch.setattr("haptisym.verbs.effects.differences.chart", lambda *_, own=table: own)
        assert lag.stays_within(Rational(1, 2)) is said


def test_exact_functions_and_suprema_are_asked_only_where_less_does_not_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError

    scene = gains("1.2", "1.003")
    monkeypatch.setattr(Difference, "stays_within", refuse)
    search = SubsetSearch(scene, BallChain(scene), Rational(1, 100))
    assert [search._verdict(frozenset({i})) for i in (0, 1)] == [True, False]
    monkeypatch.setattr(SubsetSearch, "_within", refuse)
    assert search._verdict(frozenset({1})) is False
    with pytest.raises(AssertionError):
        search._verdict(frozenset({0}))


def test_with_nothing_left_out_crossings_are_those_of_the_scene() -> None:
    scene = hs.load_scene("fu2019")
    found = relevance(scene, 0)
    assert found.dropped == ()
    assert [(x.part, float(x.low), float(x.high)) for x in found.crossings] == [
        (c.part, float(c.omega), float(c.omega)) for c in hs.evaluate(scene).crossings
    ]


def test_crossings_are_told_in_the_order_of_their_low_ends() -> None:
    """r_r passes 0.008 +- 0.004 from 0.63 to 1.1 rad/s, r_i 0.1 +- 0.002 within that."""
    scene = hs.Scene(SPRING, (LAG, hs.effects.series("1.004", name="gain")), (0, 5), hs.Threshold.of("0.008", "0.1"))
    found = relevance(scene, "0.01").crossings
    assert [x.part for x in found] == [hs.Part.REAL, hs.Part.IMAG]
    assert float(found[0].low) < float(found[1].low) < float(found[1].high) < float(found[0].high)


@pytest.mark.parametrize("band", [(0, 5), (20, 40)])
def test_an_interval_cut_by_the_end_of_the_band_may_hold_no_crossing(band: tuple[int, int]) -> None:
    """r_i = x/(1 + x^2) rises through 0.4 at 5 rad/s and falls at 20: at the very end of the band."""
    effects = (LAG, hs.effects.series("1.04", name="gain"))
    [x] = relevance(hs.Scene(SPRING, effects, band, hs.Threshold.of(5, "0.4")), "0.05").crossings
    assert not x.certain
    assert band[0] <= float(x.low) < float(x.high) <= band[1]


@pytest.mark.parametrize("jnd", ["0.08 + 0.001*omega", "0.005 + 0.004*omega"])
def test_crossings_of_a_limit_that_grows_are_enclosed_though_an_effect_is_left_out(jnd: str) -> None:
    """By the evaluation of the whole scene; of the second limit the tolerance itself is more, next to 0 rad/s."""
    scene = hs.parse_scene(f"""
        environment = {{model = "mass-spring-damper", m = 1.8, b = 15, k = 100}}
        effects = [
            {{model = "second-order-lowpass", omega_n = 80, zeta = "0.5"}},
            {{name = "quick", model = "first-order-lag", omega_c = 4000}},
        ]
        evaluation = {{band = [0, 15], jnd = "{jnd}"}}
    """)
    found = hs.relevance(scene)
    assert [x.name for x in found.dropped] == ["quick"]
    for x in hs.evaluate(scene).crossings:
        own = [y for y in found.crossings if y.criterion.name == x.criterion.name]
        assert sum(y.bounds[0] <= float(x.omega) <= y.bounds[1] for y in own) == 1
    assert found.crossings


def test_of_sets_the_fewest_effects_are_chosen_and_of_these_the_lowest_bound() -> None:
    """Whatever the verdicts of all sets are; that no smaller one does is said where none of these is open."""
    pick = Random(11)

    class Told(SubsetSearch):
        def _verdict(self, kept: Any) -> bool | None:
            return verdicts[kept]

        def _choice(self, kept: Any, *, smallest: bool) -> Any:
            return SimpleNamespace(kept=kept, smallest=smallest, worst=worst[kept])

    for _ in range(200):
        everything = frozenset(range(pick.randint(0, 4)))
        sets = [frozenset(x) for n in range(len(everything) + 1) for x in combinations(everything, n)]
        likely = pick.choice([[False], [False, False, False, True], [False, False, None, True], [False, None]])
        verdicts: dict[Any, bool | None] = {x: pick.choice(likely) for x in sets}
        worst = dict(zip(sets, pick.sample(range(99), len(sets)), strict=True))
        found: Any = Told(None, SimpleNamespace(everything=everything), Rational(1)).choose()  # type: ignore[arg-type]
        proper = [x for x in sets if x != everything and verdicts[x]] or [everything]
        size = min(map(len, proper))
        assert found.kept == min((x for x in proper if len(x) == size), key=lambda x: worst[x])
        smaller, alike = ([x for x in sets if len(x) in n and x != everything] for n in (range(size), range(size + 1)))
        if any(verdicts[x] is None for x in smaller):
            assert not found.smallest
        elif all(verdicts[x] is not None for x in alike):
            assert found.smallest


def test_a_set_is_within_a_tolerance_where_both_parts_are_and_beyond_it_where_one_is() -> None:
    """Unless a sample is proven to be beyond it; the float that is asked with is none above the tolerance."""

    class Told(SubsetSearch):
        def _sampled(self, _: Any) -> Any:
            return sampled, hs.Part.REAL, None

        def _at(self, *_: Any) -> float:
            return proven

        def _difference(self, _: Any, part: hs.Part) -> Any:
            return part

        def _within(self, part: Any) -> bool | None:
            return told[part]

    pick = Random(5)
    for tolerance in (Rational(pick.randint(1, 999), pick.randint(1, 999)) for _ in range(40)):
        search = Told(None, None, tolerance)  # type: ignore[arg-type]
        limit = search._limit
        assert Rational(limit) <= tolerance < Rational(nextafter(limit, inf))
        for verdicts in product((True, False, None), repeat=2):
            told = dict(zip(hs.Part, verdicts, strict=True))
            for sampled, proven in product((limit, nextafter(limit, inf)), repeat=2):
                is_beyond = sampled > limit and proven > limit
                expected = False if is_beyond or False in verdicts else None if None in verdicts else True
                assert search._verdict(frozenset()) is expected


def test_an_effect_that_changes_next_to_nothing_changes_something() -> None:
    """A delay of 1e-30 s: Im dH/k = -sin(omega tau), next to 15e-30 at the band's end."""
    found = change(
        hs.Scene(hs.environments.kelvin_voigt(100, 0), (hs.effects.delay(Rational(1, 10**30)),)), set(), hs.Part.IMAG
    )
    assert found.supremum().most >= 15e-30 * (1 - 1e-12)


@pytest.mark.parametrize("gain", ["9/10", "11/10"])
def test_where_signs_matter_a_change_is_not_undone_by_its_opposite(gain: str) -> None:
    """Felt are 11/10 k and, without the second gain, 9/10 k: both as far from k, and 1/5 k from each other."""
    one = hs.effects.series(gain)
    other = hs.effects.series(str(2 / Rational(gain) - 1))
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 1), (one, other))
    for signed, most in ((False, Integer(0)), (True, Rational(1, 5))):
        found = Difference(scene, BallChain(scene), frozenset({0}), hs.Part.REAL, signed)
        assert len(found.squares) == 2 - signed
        assert found.supremum().least <= float(most) <= found.supremum().most <= float(most) * (1 + WIDTH) + 1e-9
        assert found.stays_within(most + Rational(1, 10**9)) is True
        if signed:
            assert found.stays_within(most - Rational(1, 10**9)) is False
            assert found._exact_bounds(BandPiece())[1] >= 0.2


def test_the_larger_change_of_both_parts_is_as_large_as_the_larger_bounds() -> None:
    rows = {Part.REAL: SupremumBounds(0.1, 0.5, 0.6), Part.IMAG: SupremumBounds(0.3, 0.4, 0.9)}
    for given in (rows, {x: rows[y] for x, y in zip(rows, reversed(rows), strict=True)}):
        asked: Any = SimpleNamespace(without=lambda _, part, own=given: SimpleNamespace(range=lambda _: own[part]))
        assert Relevance._range(asked, 0, BandPiece()) == SupremumBounds(0.3, 0.5, 0.9)
