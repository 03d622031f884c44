"""The words of tolerances, of answers put together by hand: hands, enclosures, examples, quantiles, and drawings made late."""

from __future__ import annotations

from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Rational, Symbol

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.pages import late, tolerances
from haptisym.verbs.stability.boxes import Share
from haptisym.verbs.tolerances.verdicts import Verdict
from haptisym.writing.document import Document, Figure, Section, Table
from haptisym.writing.plain import plain, said

SPRING = hs.environments.mass_spring_damper(k=100)
FREE = hs.Scene(SPRING, (hs.effects.first_order_lag(20),), (0, 15), "0.1")
CLOCKED = hs.Scene(SPRING, (hs.effects.sampled_loop("10 ms", "tustin"),), (0, 15), "0.1", rendered=SPRING)


def number(x: object) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


def shown(blocks: Any) -> str:
    return " ".join(plain(Document("", (), tuple(blocks))).replace("\xa0", " ").split())


def hand(name: str, *ranges: tuple[str, Any]) -> Any:
    parameters = [Made(symbol=Symbol(x), interval=None if y is None else tuple(map(Rational, y))) for x, y in ranges]
    return Made(name=name, parameters=parameters)


def held(share: Share | None, stable: Any = None, unstable: Any = None, reason: str = "") -> Any:
    return Made(
        hand=hand("a", ("m", (1, 2)), ("b", None), ("k", (30, 40))),
        share=share,
        stable=stable,
        unstable=unstable,
        reason=reason,
    )


def answer(*own: Any, scene: hs.Scene = FREE) -> Any:
    knobs = {"hand.m": Made(name="m"), "environment.k": Made(name="k")}
    return Made(
        held=own,
        box=Made(
            scene=Made(knobs=knobs, effects=scene.effects, environment=scene.environment, rendered=scene.rendered)
        ),
    )


STABLE, UNSTABLE = {"hand.m": Rational(3, 2), "environment.k": Rational(7)}, {"hand.m": Rational(2)}
HELD = "held in a (m from 1 to 2 and k from 30 to 40), "


@pytest.mark.parametrize(
    ("own", "told"),
    [
        (held(Share.ALL, STABLE, UNSTABLE), f"Proven: {HELD}the display is stable for ALL values within the ranges."),
        (held(Share.NONE, STABLE, UNSTABLE), f"Proven: {HELD}for NONE of the values within the ranges is the display stable."),
        (held(Share.SOME, STABLE, UNSTABLE), f"Proven: {HELD}it DEPENDS on the values within the ranges whether the display is stable. Stable, for example, with m = 1.5 and k = 7. Not stable, for example, with m = 2."),
        (held(Share.SOME, STABLE), f"Proven: {HELD}it DEPENDS on the values within the ranges whether the display is stable. Stable, for example, with m = 1.5 and k = 7."),
        (held(None, None, UNSTABLE, "it is long"), f"UNDECIDED: {HELD}whether the display is stable: it is long. Not stable, for example, with m = 2."),
    ],
)  # fmt: skip
def test_of_each_hand_it_is_told_whether_it_holds_for_all_values_with_an_example_of_either_kind(
    own: Any, told: str
) -> None:
    *blocks, figure = tolerances._held(answer(own))
    assert shown(blocks) == told
    assert isinstance(figure, Figure)
    assert "Line: the boundary for the nominal values, in floats." in said(figure.caption)


def test_a_hand_without_ranges_has_none_in_brackets_and_a_clock_no_line_in_floats() -> None:
    bare = Made(hand=hand("b", ("m", None)), share=Share.ALL, stable=None, unstable=None, reason="")
    *blocks, figure = tolerances._held(answer(bare, scene=CLOCKED))
    assert shown(blocks) == "Proven: held in b, the display is stable for ALL values within the ranges."
    assert isinstance(figure, Figure)
    assert "Line:" not in said(figure.caption)
    assert said(figure.caption).endswith("it depends, or was not shown.")
    assert list(tolerances._held(answer())) == []


def enclosure(**own: Any) -> Any:
    criterion = Made(joint=None, symbol="r_i")
    given = {
        "criterion": criterion,
        "low": number(2),
        "high": number("2.5"),
        "at_low": None,
        "at_high": None,
        "count": 1,
        "monotonic": {"k": 1, "b": -1, "m": 1, "z": 0},
    }
    return Made(**(given | own))


def test_an_enclosure_tells_which_ends_are_reached_how_many_crossings_and_what_moves_it() -> None:
    for own, told in (
        (enclosure(), ["r_i", "2.00000", "2.50000", "1 always", "k, m", "b"]), (enclosure(at_low={}, count=None), ["r_i", "=2.00000", "2.50000", "any number", "k, m", "b"]),
        (enclosure(at_high={"k": 1}, monotonic={}), ["r_i", "2.00000", "=2.50000", "1 always", "-", "-"]),
        (enclosure(criterion=Made(joint=Made(kind="ellipse"), symbol="x")), ["dH", "2.00000", "2.50000", "1 always", "k, m", "b"]),
    ):  # fmt: skip
        assert [said(x) for x in tolerances._row(own)] == told


def test_enclosures_are_guaranteed_where_anything_varies_and_else_proven() -> None:
    def section(sides: Any, samples: Any = (), *, joint: Any = None, enclosures: Any = None) -> Any:
        own: Any = Made(
            criteria=[Made(joint=joint)],
            enclosures=(enclosure(),) if enclosures is None else enclosures,
            box=Made(sides=sides),
            samples=samples,
        )
        return tolerances._enclosures(own)

    for sides, title, end in (((1,), "Guaranteed: where the ratios meet their thresholds, whatever the values", "is reached, at a corner of the ranges; any other is a bound, which crossings may come near or not."),
                              ((), "Proven: where the ratios meet their thresholds", "is a crossing, exactly; any other is a bound.")):  # fmt: skip
        found = section(sides)
        assert isinstance(found, Section)
        assert said(found.title) == title
        table, words, figure = found.blocks
        assert isinstance(table, Table)
        assert said(words.words) == f"An end marked = {end}"  # type: ignore[union-attr]
        assert isinstance(figure, Figure)
        assert said(figure.caption) == "Grey: where crossings may lie, proven for all values."
    drawn = section((1,), (1, 2)).blocks[2]
    assert said(drawn.caption).endswith("proven for all values. Dots: crossings of the sets that were drawn at random.")
    ellipse = section((1,), joint=Made(kind="ellipse"))
    assert (
        said(ellipse.title) == "Guaranteed: where the distortion meets the border of the ellipse, whatever the values"
    )
    assert said(ellipse.blocks[0].columns[0].heading) == "distortion"
    assert said(section((1,)).blocks[0].columns[0].heading) == "ratio"
    none = section((1,), enclosures=())
    assert said(none.words) == "No ratio meets its threshold on the band, for any values within the ranges: proven."


def test_the_bandwidth_is_told_as_a_range_as_one_or_as_not_proven() -> None:
    for ends, told in ((None, "That the display is transparent from the low end of the band on is not proven for all values."), ((number(2), number(2)), "Proven: the bandwidth is 2 rad/s (0.31831 Hz)."),
                       ((number(2), number(4)), "Guaranteed: the bandwidth lies between 2 rad/s (0.31831 Hz) and 4 rad/s (0.63662 Hz).")):  # fmt: skip
        own: Any = Made(bandwidth=ends)
        assert said(tolerances._bandwidth(own)) == told


@pytest.mark.parametrize("verdict", list(Verdict))
@pytest.mark.parametrize("sides", [(), (1,)])
def test_examples_are_given_where_it_depends_or_is_open_and_that_work_was_cut_short(
    verdict: Verdict, sides: Any
) -> None:
    def told(*, limit: float | None = None, transparent: Any = None, noticed: Any = None) -> str:
        own: Any = Made(
            verdict=verdict,
            box=Made(sides=sides),
            transparent=transparent,
            noticed=noticed,
            limit=limit,
            samples=range(7),
        )
        return shown(tolerances._verdict(own))

    one = Made(values={"k": Rational(5, 2)})
    open_ = verdict in (Verdict.DEPENDS, Verdict.UNDECIDED)
    if not sides and verdict is Verdict.DEPENDS:
        return  # nothing can depend on ranges that there are not
    assert ("Transparent, for example, with k = 2.5." in told(transparent=one)) == open_
    assert ("Noticed, for example, with k = 2.5." in told(noticed=one)) == open_
    assert ("of which nothing varies" in told()) == (not sides)
    cut = told(limit=1.5)
    assert (
        "Work was cut short to keep within the limit of 1.5 s: enclosures may be wider than they need be, and 7 sets of values were drawn."
        in cut
    )
    assert "cut short" not in told()


def test_a_drawing_is_made_only_when_it_is_wanted_and_told_that_it_is_wide(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(late, "resolve_name", lambda name: lambda *given, **own: asked.append((name, given, own)))
    for wide in (True, False):
        figure = late.drawing("n", "caption", "module:function", 1, 2, wide=wide)
        assert (figure.name, figure.caption, figure.wide) == ("n", "caption", wide)
        assert len(asked) == (not wide)
        figure.draw()
    assert asked == [
        ("haptisym.figures.module:function", (1, 2), {"wide": True}),
        ("haptisym.figures.module:function", (1, 2), {}),
    ]
