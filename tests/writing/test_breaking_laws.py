"""Where long formulas of a page are broken into lines, and what the results of code are said to be."""

from __future__ import annotations

import pytest

import haptisym as hs
from haptisym.model.quantities import MotionKind
from haptisym.writing.boxes import Box, Numeral, Product
from haptisym.writing.code.entry import _results, distortion_code
from haptisym.writing.code.languages import Language
from haptisym.writing.mathematics import _NEVER, _fitting, _Piece, _pieces
from haptisym.writing.names import named


@pytest.mark.parametrize(
    ("penalties", "room", "taken"),
    [
        ([_NEVER, 0, 10, 0], 100, 4),  # all of them fit
        ([_NEVER, 0, 10, 0], 10, 3),
        ([_NEVER, 0, 10, 10], 10, 3),  # not before the second, which would leave a line less than half full
        ([_NEVER, 10, 0, 10], 10, 2),  # a worse place is not taken because more would fit
        ([_NEVER, 10, _NEVER, _NEVER], 10, 1),  # nor one where nothing may be broken
        ([_NEVER, _NEVER, _NEVER, _NEVER], 10, 3),  # unless there is no other
        ([_NEVER, 0, 0, 0], 2, 1),  # one piece is on every line, as wide as it may be
    ],
)
def test_a_line_takes_what_fits_and_ends_at_the_best_place_behind_its_middle(
    penalties: list[int], room: float, taken: int
) -> None:
    """Pieces of 3 em each."""
    assert _fitting([_Piece("x", 3.0, penalty) for penalty in penalties], room) == taken


def test_a_product_begins_with_its_first_factor_and_a_sign_stands_where_two_numbers_meet() -> None:
    factors: tuple[Box, ...] = (Numeral("3"), named("x"), Numeral("2"), Numeral("7"))
    first, *others = _pieces(Product(factors), 0)
    assert first.text.startswith("<mn>3")
    assert ["⋅" in x.text for x in others] == [False, False, True]


@pytest.mark.parametrize(("motion", "unit"), [(MotionKind.TRANSLATION, "N/m"), (MotionKind.ROTATION, "N*m/rad")])
def test_code_says_the_unit_of_what_is_a_force_per_position_and_none_of_a_ratio(motion: MotionKind, unit: str) -> None:
    told = _results(motion)
    assert {name for name, (_, own) in told.items() if own == unit} == {
        f"{kind}{part}" for kind in ("", "environment_", "perceived_") for part in ("real", "imag")
    }
    assert {own for _, own in told.values()} == {unit, ""}
    lag = hs.effects.first_order_lag(hs.symbols("omega_c"))
    code = distortion_code(hs.distort(hs.environments.kelvin_voigt("90 N/m", 3), lag), Language.OCTAVE)
    [line] = [x for x in code.splitlines() if "real part of the distortion" in x]
    assert "N/m" in line
