"""Published thresholds: the shipped table, the same in the documents, and scenes that take one by its name."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import haptisym as hs
from haptisym.cli import app
from haptisym.writing.latex import latex

SCENE = 'environment = {{ model = "mass-spring-damper", k = 1 }}\n[evaluation]\njnd = {{ like = "{}" }}\n'
EVIDENCE = Path(__file__).parents[2] / "docs" / "evidence.md"


def row(x: hs.Published) -> str:
    """A line of the table in docs/evidence.md."""
    criterion = "" if x.criterion is None else f"{float(100 * x.criterion):g} %"
    doi = f" [{x.doi}](https://doi.org/{x.doi})" if x.doi else ""
    apart = f"; not for a scene: {x.apart}" if x.apart else ""
    return (
        f"| `{x.name}` | {x.quantity} | {x.written} | {criterion} | {x.reference}{apart} | {x.source}{doi} | {x.read} |"
    )


def test_the_table_of_the_documents_is_the_shipped_one() -> None:
    head = ["| name | of what | JND | criterion | reference | source | read |", "|---|---|---|---|---|---|---|"]
    lines = EVIDENCE.read_text(encoding="utf-8").splitlines()
    begin = lines.index(head[0])
    assert lines[begin : begin + 2 + len(hs.published())] == [*head, *map(row, hs.published())]


def test_every_entry_is_a_fraction_with_a_source_and_says_how_far_that_was_read() -> None:
    for x in hs.published():
        assert 0 < x.low <= x.high <= 1
        assert x.criterion is None or 0.5 < x.criterion < 1
        assert x.source
        assert x.read


@pytest.mark.parametrize("name", [x.name for x in hs.published()])
def test_a_scene_takes_one_by_its_name_unless_it_is_no_threshold_for_one(name: str) -> None:
    [x] = [x for x in hs.published() if x.name == name]
    if x.apart:
        with pytest.raises(hs.SceneError, match="is no threshold for a scene"):
            hs.parse_scene(SCENE.format(name))
        return
    found = hs.parse_scene(SCENE.format(name)).threshold
    assert found == hs.Threshold.like(name)
    assert (found.real_interval or (found.real, found.real)) == (x.low, x.high)
    assert found.source == name


def test_a_range_of_a_source_gives_its_range_of_bandwidths() -> None:
    scene = hs.load_scene("fu2019").with_band(0, 60)
    own = hs.evaluate(hs.Scene(scene.environment, scene.effects, scene.band, hs.Threshold.like("weight")))
    ends = [hs.evaluate(scene.with_values({"c": c})).bandwidth for c in ("0.22", "0.44")]
    assert own.bandwidths is not None
    assert [own.bandwidths.least.digits(20), own.bandwidths.most.digits(20)] == [x.digits(20) for x in ends]
    assert own.to_dict()["like"] == "weight"
    assert "as `weight`: static weight" in str(own)


def test_another_value_is_no_longer_the_published_one() -> None:
    scene = hs.parse_scene(SCENE.format("force-pinch"))
    assert scene.with_values({"c": "0.08"}).threshold.source == ""
    assert "like" not in hs.evaluate(scene.with_values({"c": "0.08"})).to_dict()


def test_two_jnd_of_one_paper_are_one_by_their_criteria() -> None:
    """19 % at 71 % correct is 34.14 % at 84 %: as the same Gaussian has it, and as the paper says."""
    from statistics import NormalDist

    one, other = (
        next(x for x in hs.published() if x.name == name) for name in ("viscosity-forced-choice", "viscosity-matching")
    )
    z = NormalDist().inv_cdf
    assert float(one.low) * z(float(other.criterion)) / z(float(one.criterion)) == pytest.approx(
        0.3414387697, abs=1e-10
    )
    assert float(other.low) == pytest.approx(0.34)


@pytest.mark.parametrize(
    ("jnd", "told"),
    [
        ('{ like = "viscosity" }', 'no published threshold "viscosity"'),
        ("{ like = 3 }", 'no published threshold "3"'),
        ('{ like = "wieght" }', 'did you mean "weight"?'),
        ('{ like = "weight", real = 0.1 }', 'unknown key "real"'),
    ],
)
def test_a_name_that_is_none_is_told(jnd: str, told: str) -> None:
    with pytest.raises(hs.SceneError) as raised:
        hs.parse_scene(SCENE.replace('{{ like = "{}" }}', jnd).replace("{{", "{").replace("}}", "}"))
    assert told in str(raised.value)


def test_what_is_to_be_typed_keeps_its_quotation_marks_in_latex() -> None:
    assert r"\texttt{jnd = \{ like = \char34{}steering-wheel\char34{} \}}" in latex(hs.published().document())


def test_the_command_lists_them() -> None:
    done = CliRunner().invoke(app, ["jnd", "--published", "--json"])
    document = json.loads(done.stdout)
    assert done.exit_code == 0
    assert document == hs.published().to_dict()
    assert document["schema"] == "haptisym.published/1"
    assert [x["name"] for x in document["thresholds"]] == [x.name for x in hs.published()]
    for wrong in (["jnd", "a.csv", "--published"], ["jnd", "--published", "--reference", "3"], ["jnd"]):
        assert isinstance(CliRunner().invoke(app, wrong).exception, hs.SceneError)
