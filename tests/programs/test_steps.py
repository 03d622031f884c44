"""A straight-line computation is worth what its expressions are worth, at any stage."""

from __future__ import annotations

import pytest
from sympy import Integer, Rational, Symbol, cos, symbols

import haptisym as hs
from haptisym.programs.steps import Steps

a, b, x0 = symbols("a b x0")


def test_sharing_changes_no_result():
    d = hs.load_scene("steering-wheel").symbolic_distortion()
    forms = {"real": d.real, "imag": d.imag, "relative": d.relative_real}
    steps = Steps.sharing(forms)
    point = {x: Rational(n + 3, 7) for n, x in enumerate(sorted(steps.free_symbols, key=str))}
    assert steps.at(point) == {name: form.xreplace(point) for name, form in forms.items()}


def test_sharing_saves_operations_and_keeps_the_arguments():
    d = hs.load_scene("fu2019").symbolic_distortion()
    plain = Steps((), {"real": d.real, "imag": d.imag})
    steps = plain.shared()
    assert steps.operations < plain.operations
    assert steps.free_symbols == plain.free_symbols == {hs.omega, *d.free_symbols}


def test_an_operation_in_a_definition_is_counted_once():
    steps = Steps(((b, cos(a) + 1),), {"y": b * b + b, "z": 2 * b})
    assert steps.operations == 2 + 2 + 1


def test_a_defined_name_is_never_one_of_the_arguments():
    steps = Steps.sharing({"y": (x0 + a) ** 2 + (x0 + a)})
    assert [name.name for name, _ in steps.definitions] == ["x1"]
    assert steps.at({x0: Integer(1), a: Integer(2)}) == {"y": 12}


def test_definitions_are_put_into_later_definitions():
    c = Symbol("c")
    assert Steps(((b, a + 1), (c, b**2)), {"y": c + b}).expressions() == {"y": (a + 1) ** 2 + a + 1}


@pytest.mark.parametrize("definitions", [((a, b), (b, x0)), ((a, a + 1),), ((a, x0), (a, b))])
def test_a_name_is_defined_once_and_before_its_use(definitions):
    with pytest.raises(hs.SceneError, match=r"before its definition|twice"):
        Steps(definitions, {})


def test_sharing_keeps_the_definitions_that_are_there():
    c, d = symbols("c d")
    steps = Steps(((c, cos(a) + b), (d, c**2 + cos(a))), {"y": d * (c + 1), "z": (c + 1) ** 3}).shared()
    names = [name.name for name, _ in steps.definitions]
    assert {"c", "d"} < set(names)
    assert names.index("c") < names.index("d")
    assert sum(value.has(cos) for _, value in steps.definitions) == 1
    c_value = cos(a) + b
    assert steps.expressions() == {"y": (c_value**2 + cos(a)) * (c_value + 1), "z": (c_value + 1) ** 3}


def test_what_a_whole_power_is_taken_of_has_a_name():
    [(name, value)] = Steps.sharing({"y": 1 / (a + b) ** 3}).definitions
    assert (name.name, value) == ("x0", a + b)
