"""Every document that ``--json`` prints is what its schema says, judged by a validator that is not ours."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name, walk_packages
from typing import Any

import pytest
from marks import required
from schemas import faults, parsed

import haptisym as hs
from haptisym.figures.files import Drawings
from haptisym.judge.answers import Answer
from haptisym.writing.schemas import schema_names

required("jsonschema, of the extra test,", find_spec("jsonschema"))
jsonschema = import_module("jsonschema")

HAND = ("--hand", "postural-arm")
OF_A_SCENE: tuple[tuple[str, ...], ...] = (
    ("evaluate", "{}", "--regions", "--discriminate"),
    ("effects", "{}"),
    ("metrics", "{}"),
    ("derive", "{}"),
    ("stability", "{}", *HAND),
    ("sensitivity", "{}"),
    ("tolerances", "{}", "--samples", "3"),
    ("require", "{}", "--free", "evaluation.jnd"),
    ("simulate", "{}"),
    ("simulate", "{}", "--release", "1 cm", *HAND),
)
"""What is asked of every shipped scene."""
MAP = ["--free", "zeta", "--free", "omega_n", "--range", "0.4", "0.6", "--range", "60", "200", "--slices", "3"]
OTHERS: dict[str, tuple[str, ...]] = {
    "designmap": ("require", "fu2019", *MAP, "--that", "transparent", "--that", "passive"),
    "design": ("design", "fu2019", "--free", "zeta=0.3:1", "--keep", "passive"),
    "requirement": ("require", "fu2019", "--free", "omega_n", "--that", "transparent", "--that", "stable", *HAND),
    "evaluation": ("evaluate", "fu2019", "--regions", "--discriminate", "--tolerance", "0.2"),
    "evaluations": ("evaluate", "palpation-device", "--regions"),
    "answers": ("require", "palpation-device", "--free", "omega_c", "--that", "stable", *HAND),
    "comparison": ("compare", "fu2019", "helicopter-cyclic"),
    "effects": ("effects", "fu2019"),
    "metrics": ("metrics", "fu2019"),
    "controlloading": ("metrics", "fu2019", "--rule", "14cfr60-a2a", "--sweep", "4 s"),
    "derivation": ("derive", "fu2019"),
    "stability": ("stability", "fu2019", *HAND),
    "sensitivity": ("sensitivity", "fu2019"),
    "tolerances": ("tolerances", "fu2019-tolerances", "--samples", "2"),
    "simulation": ("simulate", "fu2019"),
    "release": ("simulate", "fu2019", "--release", "1 cm", *HAND),
    "sweep": ("sweep", "fu2019", "--vary", "evaluation.jnd=0.1:0.2:3"),
    "published": ("jnd", "--published"),
    "jnd": ("jnd", "{answers}", "--reference", "10"),
    "measured": ("evaluate", "{bench}"),
    "identification": ("identify", "{bench}", "--effect", "first-order-lag"),
    "zwidth": ("identify", "wheel-with-encoder", "--zwidth", "{walls}", "--free", "effects.wheel.b"),
    "scenes": ("scenes",),
    "schemas": ("schemas",),
}
"""A call for each kind of document; ``cost`` and ``peaks`` are asked for in Python."""
SLOW = {
    "evaluations",
    "requirement",
    "scenes",
    "sensitivity",
    "derivation",
    "designmap",
    "metrics",
    "simulation",
    "release",
    "sweep",
    "tolerances",
    "jnd",
    "measured",
    "identification",
    "zwidth",
}
"""What has its documents validated in the quick suite anyway, by the calls of other tests."""
BENCH = """
[environment]
model = "kelvin-voigt"
k = "100 N/m"
b = "2 N*s/m"
[perceived]
file = "bench.csv"
[evaluation]
band = ["0 rad/s", "10 rad/s"]
"""


@pytest.fixture
def files(tmp_path: Path) -> dict[str, str]:
    """A measured response and a person's answers."""
    (tmp_path / "bench.csv").write_text("omega,real,imag,radius\n1,99,2,5\n2,120,4,1\n3,110,6,3\n", encoding="utf-8")
    (tmp_path / "bench.toml").write_text(BENCH, encoding="utf-8")
    (tmp_path / "answers.csv").write_text("level,k,n\n8,1,20\n9,4,20\n10,10,20\n11,17,20\n12,19,20\n", encoding="utf-8")
    (tmp_path / "walls.csv").write_text("K,B\n0.4,0\n0.5,5e-5\n0.6,1e-4\n", encoding="utf-8")
    return {
        "walls": str(tmp_path / "walls.csv"),
        "bench": str(tmp_path / "bench.toml"),
        "answers": str(tmp_path / "answers.csv"),
    }


def kinds_below(kind: type[Answer]) -> Iterator[type[Answer]]:
    """All classes that are derived from one, of the modules that are loaded."""
    for derived in kind.__subclasses__():
        yield derived
        yield from kinds_below(derived)


def test_every_answer_has_a_page_a_figure_and_a_schema_and_every_schema_an_answer() -> None:
    for found in walk_packages(hs.__path__, "haptisym."):
        if not found.name.endswith("__main__"):
            import_module(found.name)
    kinds = set()
    for answer in kinds_below(Answer):
        page, figure, schema = (getattr(answer, f"_{x}", "") for x in ("page", "figure", "schema"))
        assert callable(page and resolve_name(page)), answer
        assert isinstance(figure and resolve_name(figure), Drawings), answer
        kinds.add(schema.removeprefix("haptisym.").removesuffix("/1"))
    assert set(schema_names()) == kinds | {"scenes", "schemas"} == {*OTHERS, "cost", "peaks"}


@pytest.mark.slow
def test_schemas_are_valid_and_give_one_name_one_meaning() -> None:
    meanings: dict[str, Any] = {}
    for name in schema_names():
        schema = hs.json_schema(name)
        jsonschema.Draft202012Validator.check_schema(schema)
        assert schema["properties"]["schema"] == {"const": f"haptisym.{name}/1"}
        assert schema["$id"] == f"urn:haptisym:{name}:1"
        for word, meaning in schema.get("$defs", {}).items():
            assert meanings.setdefault(word, meaning) == meaning, (name, word)


@pytest.mark.dear("effects", "evaluation", "stability")
@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.slow] * (x in SLOW)) for x in OTHERS])
def test_a_document_is_what_its_schema_says(call, files: dict[str, str], name: str) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*(word.format(**files) for word in OTHERS[name]), "--json")
    assert status == 0, err
    refuses_what_is_not(parsed(out))


def test_documents_that_are_asked_for_in_python_are_what_their_schemas_say() -> None:
    refuses_what_is_not(hs.peaks("fu2019").to_dict())


@pytest.mark.slow
def test_what_accuracy_costs_is_what_its_schema_says(call) -> None:  # type: ignore[no-untyped-def]
    refuses_what_is_not(parsed(call("cost", "fu2019", "--quick", "--json")[1]))


def refuses_what_is_not(document: dict[str, Any]) -> None:
    """The schema takes the document, another key too; without any key that it requires, or with null in its place, it does not."""
    assert faults(document) == []
    assert faults(document | {"further": 1}) == []
    schema = hs.json_schema(document["schema"])
    assert set(document) <= set(schema["properties"]) | {"nominal", "untied"}
    for key in set(schema["required"]) - {"schema"}:
        assert faults({k: v for k, v in document.items() if k != key}), key
        assert faults(document | {key: {"not": "so"}}) or isinstance(document[key], dict), key


@pytest.mark.slow
@pytest.mark.parametrize("scene", hs.scene_names())
def test_every_document_about_every_shipped_scene_is_what_its_schema_says(call, scene: str) -> None:  # type: ignore[no-untyped-def]
    for words in OF_A_SCENE:
        status, out, err = call(*(word.format(scene) for word in words), "--json", *LIMITS.get(words[0], ()))
        assert status in (0, 2, 3), (words, err)
        assert (status == 2) == (out == "")
        assert out == "" or faults(parsed(out)) == [], words


LIMITS = dict.fromkeys(("evaluate", "effects", "sensitivity", "tolerances", "require"), ("--limit", "120"))


def test_the_command_line_hands_out_what_validators_take(call) -> None:  # type: ignore[no-untyped-def]
    assert json.loads(call("schemas", "haptisym.evaluation/1")[1]) == hs.json_schema("evaluation")
    assert [x["name"] for x in json.loads(call("schemas", "--json")[1])["schemas"]] == schema_names()
    status, out, err = call("schemas", "evaluaton")
    assert (status, out) == (2, "")
    assert 'did you mean "evaluation"?' in err
    assert call("schemas", "evaluation", "--json")[0] == 2
