"""The page of a sweep, of what is told put together by hand: each range, count and set that was not answered."""

from __future__ import annotations

import itertools
from math import pi
from types import SimpleNamespace
from typing import Any

from pagewords import row

import haptisym as hs
from haptisym.pages import sweep as sweep_page
from haptisym.writing.document import Document, Figure
from haptisym.writing.plain import plain

SCENE = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("10 ms"),), (0, 15), "0.1")


def figures(document: Document) -> list[str]:
    return [x.name for x in document.blocks if isinstance(x, Figure)]


def swept(**own: Any) -> str:
    told: dict[str, Any] = {
        "vary": [{"path": "effects.delay.tau", "unit": "s", "low": 0.001, "high": 0.0123456789, "values": 2001}], "band": [0.0, 15.0],
        "ranges": {"bandwidth": [1.5, 2 * pi], "first_crossing_imag": None, "changeover_perceived": [pi, pi], "transparent": [0.25, 0.5]},
        "counts": {"crossings_real": {"0": 1500, "2": 501}, "crossings_imag": {}}, "sets": 2001, "certified_in_floats": 1999, "exact": 2, "open": 0,
        "open_at": [], "out": None,
    }  # fmt: skip
    found = SimpleNamespace(to_dict=lambda: told | own, scene=SCENE, asides=list, figure=None)
    return plain(sweep_page.page(found))  # type: ignore[arg-type]


def test_a_sweep_tells_what_was_varied_and_between_which_ends_each_frequency_lies_in_both_units() -> None:
    page = swept()
    assert row(page, "effects.delay.tau") == "0.001 to 0.0123457 s, 2,001 values"
    assert row(page, "band") == "0 to 15 rad/s"
    assert row(page, "bandwidth") == f"1.5 to 6.2832 {1.5 / 2 / pi:.5g} to 1"
    assert row(page, "changeover as felt") == "3.1416 0.5"
    assert row(page, "first crossing, imaginary part") == "none"
    assert "first crossing, real part" not in page
    assert row(page, "transparent part of the band") == "25 to 50 %"
    assert row(page, "crossings, real part") == "0: 1,500, 2: 501 sets"
    assert row(page, "crossings, imaginary part") == "none sets"
    assert "both parts at once" not in page
    ratio = {"path": "effects.lowpass.zeta", "low": 0.5, "high": 0.5, "values": 1}
    for unit in ("", "1"):
        assert row(swept(vary=[ratio | {"unit": unit}]), "effects.lowpass.zeta") == "0.5, 1 values"
    whole = {"bandwidth": None, "transparent": [1.0, 1.0]}
    assert row(swept(ranges=whole), "transparent part of the band") == "100 %"
    assert row(swept(ranges={"bandwidth": None, "transparent": None}), "transparent part of the band") == "none"


def test_one_or_two_parameters_of_several_values_each_are_drawn() -> None:
    def is_drawn(*values: int) -> bool:
        vary = [{"path": f"p{n}", "unit": "s", "low": 1.0, "high": 2.0, "values": x} for n, x in enumerate(values)]
        told = {
            "vary": vary,
            "band": [0.0, 1.0],
            "ranges": {"bandwidth": None, "transparent": None},
            "counts": {},
            "sets": 1,
            "certified_in_floats": 1,
            "exact": 0,
            "open": 0,
            "out": None,
        }
        found = SimpleNamespace(to_dict=lambda: told, scene=SCENE, asides=list, figure=None)
        return "sweep" in figures(sweep_page.page(found))  # type: ignore[arg-type]

    for values in itertools.chain(
        itertools.product([1, 2, 9], repeat=1), itertools.product([1, 2], repeat=2), [(2, 2, 2)]
    ):
        assert is_drawn(*values) == (len(values) <= 2 and min(values) > 1), values


def test_hands_of_a_sweep_have_their_sets_and_roots_and_what_has_no_number_of_them() -> None:
    held = [
        {"hand": "tight", "stable": 1500, "unstable": {"0": 1500, "2": 400}, "infinite": 100, "undecided": 1},
        {"hand": "soft", "stable": 0, "unstable": {"2": 2001}, "infinite": 0, "undecided": 0},
    ]
    page = swept(held=held)
    assert row(page, "stable in tight") == "1,500 of 2,001 sets"
    text = " ".join(page.split())
    assert (
        "roots that do not decay in tight 0: 1,500, 2: 400, a chain of infinitely many: 100, not decided: 1 sets"
        in text
    )
    assert "roots that do not decay in soft 2: 2,001 sets" in text
    assert "stable in" not in swept()


def test_a_sweep_ends_with_how_many_sets_were_answered_and_which_were_not() -> None:
    text = " ".join(swept().split())
    assert "Certain: 2,001 sets, 1,999 certified in floats, 2 exact." in text
    assert "NOT ANSWERED" not in text
    assert "Written to" not in text
    open_at = [{"tau": 0.1, "k": 3.0}, {"tau": 9.0, "k": 9.0}]
    missing = " ".join(swept(open=1200, open_at=open_at, out="there.nc").split())
    assert (
        "NOT ANSWERED: 1,200 sets (undecided, or no dynamics), the first at tau = 0.10000000000000001, k = 3."
        in missing
    )
    assert missing.endswith("Written to there.nc.")
    with_hands = " ".join(
        swept(
            open=1, open_at=open_at, held=[{"hand": "a", "stable": 1, "unstable": {}, "infinite": 0, "undecided": 0}]
        ).split()
    )
    assert "1 sets (undecided, or no dynamics), or not in all, the first" in with_hands
