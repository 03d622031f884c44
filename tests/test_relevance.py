"""Which effects matter: every bound against values computed with other means, and the laws that bounds obey."""

from __future__ import annotations

import json
from fractions import Fraction
from math import isclose
from pathlib import Path

import mpmath
import pytest
import strategies
from marks import QUICK_SCENES, often
from sympy import Expr, Rational, lambdify

import haptisym as hs
from haptisym.catalogue import EFFECTS
from haptisym.pruning.ballchain import BallChain, Kept, Piece, series_arithmetic
from haptisym.pruning.differences import Difference
from haptisym.pruning.figure import save_influences
from haptisym.pruning.relevance import Relevance, relevance
from haptisym.pruning.suprema import WIDTH
from haptisym.pruning.text import document, page
from haptisym.simulation.simulate import simulate
from haptisym.symbols import s

MP = mpmath.MPContext()
MP.dps = 40
MANY = "control-stick-in-detail"
SPRING = hs.environments.mass_spring_damper(k=100)


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


def function(entry: Expr) -> object:
    """An entry as a function of s on a context of mpmath of its own."""
    exact = {x: MP.mpf(x.p) / x.q for x in entry.atoms(Rational) if not x.is_Integer}
    names = {x: hs.symbols(f"q{i}") for i, x in enumerate(exact)}
    run = lambdify([s, *names.values()], entry.xreplace(names), [
        {"exp": MP.exp, "cosh": MP.cosh, "sinh": MP.sinh, "pi": MP.pi, "I": MP.j},
    ])  # fmt: skip
    return lambda at: MP.mpc(run(at, *exact.values()))


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


@pytest.mark.parametrize("name", often(hs.scene_names(), lambda name: name in QUICK_SCENES))
def test_no_sample_exceeds_a_certified_influence_and_the_best_one_comes_near(name: str) -> None:
    scene = hs.load_scene(name)
    for i in range(len(scene.effects)):
        check(scene, frozenset(range(len(scene.effects))) - {i})


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
    for piece in (Piece(3, 0), Piece(3, 5), Piece(6, 63)):
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
    assert [x["influence"]["imag"] is None for x in document(found)["effects"]] == [False, True]
    assert "unbounded" in page(found)


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


def test_the_document_has_the_agreed_keys(many: Relevance) -> None:
    told = json.loads(json.dumps(document(many)))
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


@pytest.mark.parametrize("model", EXAMPLES)
def test_nothing_of_an_effect_that_a_scene_does_not_name_appears_anywhere(model: str) -> None:
    effect = EFFECTS[model].build(**EXAMPLES[model], name="guest")
    env = hs.environments.mass_spring_damper(1, 12, 300)
    lag = hs.effects.first_order_lag("8 Hz", name="host")
    with_it, without = hs.Scene(env, (lag, effect)), hs.Scene(env, (lag,))
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


def test_the_figure_names_every_effect_and_is_the_same_every_time(tmp_path: Path, many: Relevance) -> None:
    first, second = (save_influences(many, tmp_path / name).read_bytes() for name in ("a.pdf", "b.pdf"))
    assert first == second
    text = save_influences(many, tmp_path / "c.svg").read_text(encoding="utf-8")
    assert all(f"<!-- {x.name} -->" in text for x in many.scene.effects)
    with pytest.raises(hs.SceneError, match=r"\.svg, \.pdf or \.png"):
        save_influences(many, tmp_path / "d.gif")


def test_a_scene_without_effects_has_nothing_that_matters() -> None:
    found = relevance(hs.Scene(SPRING))
    assert (found.effects, found.dominance, found.crossings, found.bound[hs.Part.REAL].most) == ((), (), (), 0)
    assert "no effects" in page(found)
