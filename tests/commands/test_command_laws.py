"""Every word of the command line reaches its question as it stands, and what is not given has its default; what comes back is written where it was asked for."""

from __future__ import annotations

import errno
import io
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import pytest
from benches import bench

import haptisym as hs
from haptisym.cli import _EXTRAS, VERBS, main
from haptisym.commands.progress import ProgressBar, progress, quiet
from haptisym.commands.spelling import escaped, spelt
from haptisym.commands.streams import note, prepare, say, say_document, to_file, to_standard_output, write
from haptisym.kernel.errors import NothingToDrawError
from haptisym.writing.document import Document, Paragraph
from haptisym.writing.latex import latex, piece
from haptisym.writing.schemas import json_schema, schema_names, schema_text

Run = Callable[..., tuple[int, str, str]]
MINE = 'title = "Mine"\nenvironment = { model = "kelvin-voigt", k = 100, b = 2 }\n[[effects]]\nmodel = "first-order-lag"\nomega_c = 20\n'


class Stub:
    """An answer of which only is asked how it is handed over."""

    title, text = "Stub", "the scene"
    files: tuple[Path, ...] = ()

    def __init__(self, certified: bool = True, drawn: str = "figure", **others: Any) -> None:  # noqa: FBT001, FBT002
        self.certified, self.drawn = certified, drawn
        self.__dict__ |= others

    def document(self) -> Document:
        return Document("The page", (), ())

    def to_json(self) -> str:
        return '{"stub": 1}'

    def json_parts(self) -> Iterator[str]:
        yield from ('{"stub"', ": 1}")

    def save_figure(self, path: Path) -> None:
        if not self.drawn:
            raise NothingToDrawError("it is empty")
        path.write_text(self.drawn, encoding="utf-8")

    def certificate(self) -> str:
        return "the proof"

    def to_csv(self) -> str:
        return "the run"

    def __getitem__(self, _: int) -> Stub:
        return self


PAGE = "The page\n\n"
JSON = '{"stub": 1}\n'


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """The command line, whatever its documents hold."""

    def called(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["haptisym", *words])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return called


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[tuple[tuple[Any, ...], dict[str, Any]]]]:
    """A question in place of which a stub answers, and which notes what it was asked."""

    def replaced(place: str, answer: Any = None) -> list[tuple[tuple[Any, ...], dict[str, Any]]]:
        seen: list[tuple[tuple[Any, ...], dict[str, Any]]] = []

        def question(*arguments: Any, **keys: Any) -> Any:
            seen.append((tuple(x.title if isinstance(x, hs.Scene) else x for x in arguments), keys))
            return Stub() if answer is None else answer

        monkeypatch.setattr(place, question)
        return seen

    return replaced


@pytest.fixture
def limits(monkeypatch: pytest.MonkeyPatch) -> list[float | None]:
    """What time is given."""
    seen: list[float | None] = []

    @contextmanager
    def given(seconds: float | None, told: Any) -> Iterator[None]:
        assert callable(told)
        seen.append(seconds)
        yield

    for place in ("limit", "evaluate", "require"):
        monkeypatch.setattr(f"haptisym.commands.{place}.limited", given)
    return seen


@pytest.fixture
def mine(tmp_path: Path) -> str:
    path = tmp_path / "mine.toml"
    path.write_text(MINE, encoding="utf-8")
    return str(path)


def without_told(keys: dict[str, Any]) -> dict[str, Any]:
    assert callable(keys["told"])
    return {key: x for key, x in keys.items() if key != "told"}


QUESTIONS: list[tuple[str, str, list[tuple[list[str], tuple[Any, ...], dict[str, Any], float | None]]]] = [
    ("stability", "haptisym.verbs.stability.entry.stability", [
        ([], ("Mine", None, ()), {"digits": 15}, 60.0),
        (["--hand", "a", "--hand", "b", "--free", "k", "--free", "b", "--json", "--digits", "40", "--limit", "7"],
         ("Mine", ("a", "b"), ("k", "b")), {"digits": 40}, 7.0),
    ]),
    ("sensitivity", "haptisym.verbs.sensitivity.entry.sensitivity", [
        ([], ("Mine", 15), {}, 60.0), (["--json", "--digits", "1000", "--limit", "1e9"], ("Mine", 1000), {}, 1e9),
    ]),
    ("effects", "haptisym.verbs.effects.entry.relevance", [
        ([], ("Mine", "0.01"), {}, 60.0), (["--tolerance", "5 %", "--limit", "0.5"], ("Mine", "5 %"), {}, 0.5),
    ]),
    ("metrics", "haptisym.verbs.metrics.entry.metrics", [([], ("Mine",), {}, None), (["--json"], ("Mine",), {}, None)]),
    ("tolerances", "haptisym.verbs.tolerances.entry.tolerances", [
        ([], ("Mine", 200, 2019), {"hand": None, "limit": 60.0}, None),
        (["--samples", "0", "--hand", "a", "--limit", "3"], ("Mine", 0, 2019), {"hand": ("a",), "limit": 3.0}, None),
        (["--samples", "100000", "--seed", "-4", "--json"], ("Mine", 100_000, -4), {"hand": None, "limit": 60.0}, None),
    ]),
    ("require", "haptisym.verbs.require.entry.require", [
        (["--free", "k"], ("Mine", "k"),
         {"digits": 15, "part": None, "that": ("transparent",), "hand": None, "any_environment": False, "limit": 60.0}, None),
        (["--free", "k", "--range", "1", "2 N/m", "--part", "imag", "--that", "stable", "--that", "passive", "--hand", "h", "--digits", "9",
          "--any-environment", "--limit", "4"], ("Mine", "k", ("1", "2 N/m")),
         {"digits": 9, "part": hs.Part.IMAG, "that": ("stable", "passive"), "hand": "h", "any_environment": True, "limit": 4.0}, None),
    ]),
    ("cost", "haptisym.verbs.cost.entry.cost", [([], ("Mine",), {"quick": False}, None), (["--quick"], ("Mine",), {"quick": True}, None)]),
    ("cost", "haptisym.verbs.cost.entry.simulation_cost", [(["--simulation"], ("Mine",), {"quick": False}, None)]),
    ("cost", "haptisym.verbs.cost.entry.sweep_cost", [
        (["--sweep"], ("Mine", ()), {"quick": False, "limit": 60.0}, None),
        (["--sweep", "--free", "k", "--free", "b", "--limit", "9", "--quick"], ("Mine", ("k", "b")), {"quick": True, "limit": 9.0}, None),
    ]),
    ("evaluate", "haptisym.commands.evaluate.evaluate_scene", [
        ([], ("Mine", 15), {"tolerance": None, "regions": False, "proportion": None}, 60.0),
        (["--digits", "10000", "--tolerance", "1 %", "--regions", "--proportion", "0.84", "--limit", "8"], ("Mine", 10_000),
         {"tolerance": "1 %", "regions": True, "proportion": "0.84"}, 8.0),
    ]),
]  # fmt: skip


@pytest.mark.parametrize(("verb", "place", "calls"), QUESTIONS, ids=[x[1].rpartition(".")[2] for x in QUESTIONS])
def test_every_option_reaches_its_question_and_what_is_not_given_has_its_default(
    run: Run, asked: Any, limits: list[float | None], mine: str, verb: str, place: str, calls: list[Any]
) -> None:
    seen = asked(place, Stub(nearest=None, bandwidths=None))
    for words, arguments, keys, limit in calls:
        status, out, err = run(verb, mine, *words)
        assert (status, out, err) == (0, JSON if "--json" in words else PAGE, "")
        given, named = seen.pop()
        assert given == arguments
        assert (without_told(named) if "told" in named else named) == keys
        assert limits[:1] == ([] if limit is None else [limit]) or verb == "require"
        limits.clear()


def test_a_map_is_asked_with_all_that_is_said_of_its_slices_and_what_is_drawn_beside(
    run: Run, asked: Any, mine: str
) -> None:
    seen = asked("haptisym.verbs.require.designmap.design_map")
    two = ("--free", "k", "--free", "b", "--range", "1", "2", "--range", "3", "4")
    assert run("require", mine, *two)[0] == 0
    assert (
        run(
            "require",
            mine,
            *two,
            "--slices",
            "9",
            "--uniform",
            "--jnd",
            "0.2",
            "--jnd",
            "0.3",
            "--friction",
            "1 N",
            "--resolution",
            "1 mm",
        )[0]
        == 0
    )
    assert run("require", mine, *two, "--within", "1 %", "--part", "real")[0] == 0
    usual = {"slices": 41, "uniform": False, "within": None, "jnd": (), "friction": None, "resolution": None, "part": None,
             "that": ("transparent",), "hand": None, "any_environment": False, "limit": 60.0}  # fmt: skip
    more = (
        {},
        {"slices": 9, "uniform": True, "jnd": ("0.2", "0.3"), "friction": "1 N", "resolution": "1 mm"},
        {"within": "1 %", "part": hs.Part.REAL},
    )
    for (arguments, keys), other in zip(seen, more, strict=True):
        assert arguments == ("Mine", ("k", "b"), (("1", "2"), ("3", "4")))
        assert without_told(keys) == usual | other


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--free k --free b --free m --range 1 2 --range 1 2 --range 1 2", "--free may be given once or twice"),
        ("--free k --range 1 2 --range 1 2", "--range not at all or as often"), ("--free k --free b --range 1 2", "--range not at all or as often"),
        ("--free k --slices 41", "--slices is about a map"), ("--free k --free b --range 1 2 --range 1 2 --digits 15", "--digits is about the ends"),
        ("--free k --jnd 0.1", "--jnd is about a map"), ("--free k --friction 1 --resolution 1", "--friction is about a map"),
        ("--free k --uniform", "--uniform is about a map"), ("--free k --within 1", "--within is about a map"),
        ("--free k --free b --range 1 2 --range 1 2 --uniform --within 1", "--uniform places slices evenly, and --within"),
        ("--free k --free b", "a map of two parameters needs a --range for each"), ("--free k --hand x", "--hand is about the hand of --that stable: it needs --that"),
        ("--free k --free b --range 1 2 --range 1 2 --friction 1", "it needs --resolution"),
        ("--free k --free b --range 1 2 --range 1 2 --resolution 1", "it needs --friction"),
    ],
)  # fmt: skip
def test_options_of_a_map_and_of_one_parameter_are_told_apart(run: Run, mine: str, words: str, said: str) -> None:
    status, out, err = run("require", mine, *words.split())
    assert (status, out) == (2, "")
    assert said in err


def test_a_certificate_of_a_map_is_refused(run: Run, mine: str, tmp_path: Path) -> None:
    words = ["--free", "k", "--free", "b", "--range", "1", "2", "--range", "1", "2", "--certificate"]
    assert "--certificate is about one parameter's values" in run("require", mine, *words, str(tmp_path / "p.json"))[2]


def test_the_certificate_of_one_parameter_is_written_beside_its_page(
    run: Run, asked: Any, mine: str, tmp_path: Path
) -> None:
    asked("haptisym.verbs.require.entry.require", Stub(nearest=None))
    told = run("require", mine, "--free", "k", "--certificate", str(tmp_path / "p.json"))
    assert told == (0, PAGE, f"certificate written to {tmp_path / 'p.json'}\n")
    assert (tmp_path / "p.json").read_text(encoding="utf-8") == "the proof"


def test_hard_cases_are_a_question_of_their_own(run: Run, asked: Any, mine: str) -> None:
    seen = asked("haptisym.verbs.cost.hardcosts.hard_costs")
    assert run("cost", "--hard-cases", "--json") == (0, JSON, "")
    [(given, named)] = seen
    assert (given, without_told(named)) == ((), {})
    for words in ((mine,), ("--quick",), ("--simulation",), ("--sweep",), ("--environment", "a")):
        status, out, err = run("cost", "--hard-cases", *words)
        assert (status, out) == (2, "")
        assert "--hard-cases brings its own scenes" in err
    assert "name a SCENE, or ask for --hard-cases" in run("cost")[2]
    assert len(seen) == 1


def test_answers_of_a_person_are_asked_about_as_the_words_say(run: Run, asked: Any) -> None:
    seen = asked("haptisym.verbs.jnd.entry.jnd")
    assert run("jnd", "a.csv") == (0, PAGE, "")
    words = ("--proportion 0.84 --alternatives 3 --reference 5 --guess 0.1 --lapse free --confidence 0.9 --method psignifit --level x --count k "
             "--trials n --where hand=left --where a=b=c --json")  # fmt: skip
    assert run("jnd", "a.csv", *words.split()) == (0, JSON, "")
    assert run("jnd", "a.csv", "--answer", "y", "--lapse", "0.02")[0] == 0
    usual = {"proportion": None, "alternatives": None, "guess": 0.0, "lapse": 0.0, "reference": None, "confidence": 0.95, "method": "likelihood",
             "where": {}, "columns": {}}  # fmt: skip
    all_of_them = {"proportion": 0.84, "alternatives": 3, "reference": 5.0, "guess": 0.1, "lapse": None, "confidence": 0.9, "method": "psignifit",
                   "where": {"hand": "left", "a": "b=c"}, "columns": {"level": "x", "count": "k", "trials": "n"}}  # fmt: skip
    assert seen == [
        (("a.csv",), usual),
        (("a.csv",), all_of_them),
        (("a.csv",), usual | {"columns": {"answer": "y"}, "lapse": 0.02}),
    ]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "jnd: name a file of answers as DATA, or ask for --published"), (("--published", "a.csv"), "--published lists what others measured"),
        (("--published", "--lapse", "0"), "--published lists what others measured"), (("--published", "--where", "a=b"), "--published lists"),
        (("a.csv", "--where", "hand"), '--where "hand": write it as COLUMN=VALUE'), (("a.csv", "--where", "=left"), "write it as COLUMN=VALUE"),
        (("a.csv", "--where", "a=1", "--where", "a=2"), "--where a is given twice"), (("a.csv", "--guess", "x"), '--guess: "x" is not'),
        (("a.csv", "--lapse", "fre"), '--lapse: "fre" is not'), (("a.csv", "--method", "least"), "least"),
    ],
)  # fmt: skip
def test_answers_of_a_person_are_not_asked_about_in_a_wrong_way(run: Run, words: tuple[str, ...], said: str) -> None:
    status, out, err = run("jnd", *words)
    assert (status, out) == (2, "")
    assert said in err


def test_published_thresholds_are_listed_in_every_form(run: Run, tmp_path: Path) -> None:
    assert run("jnd", "--published") == (0, str(hs.published()), "")
    assert run("jnd", "--published", "--json") == (0, hs.published().to_json() + "\n", "")
    status, _, err = run("jnd", "--published", "--latex", str(tmp_path / "p.tex"))
    assert (status, err) == (0, f"LaTeX written to {tmp_path / 'p.tex'}\n")
    assert (tmp_path / "p.tex").read_text(encoding="ascii") == latex(hs.published().document())


def test_a_response_is_identified_as_the_words_say(run: Run, asked: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    given = Stub(files=(path,))
    opened = asked("haptisym.verbs.identify.entry.opened", given)
    seen = asked("haptisym.verbs.identify.entry.identify")
    scene = tmp_path / "found.toml"
    assert run("identify", "a.csv", "--environment", "maxwell") == (0, PAGE, "")
    words = ("--effect", "delay", "--effect", "shunt:m", "--degrees", "1", "2", "--band", "1 Hz", "2", "--averages", "9", "--confidence", "0.9", "--estimator",
             "H1", "--segment", "4 s", "--title", "Mine", "--json", "--scene", str(scene), "--figure", str(tmp_path / "f.svg"))  # fmt: skip
    status, out, err = run("identify", "a.csv", *words)
    assert (status, out) == (0, JSON)
    assert err == f"scene written to {scene}\nfigure written to {tmp_path / 'f.svg'}\n"
    assert scene.read_text(encoding="utf-8") == "the scene"
    assert opened == [(("a.csv", None, None), {}), (("a.csv", 9.0, 0.9), {"estimator": "H1", "segment": "4 s"})]
    assert seen == [
        ((given, "maxwell", ()), {"degrees": None, "band": None, "title": ""}),
        ((given, None, ("delay", "shunt:m")), {"degrees": (1, 2), "band": ("1 Hz", "2"), "title": "Mine"}),
    ]
    path.write_text("", encoding="utf-8")
    assert (
        f"--scene: {path} is read by this very call"
        in run("identify", "b.csv", "--environment", "maxwell", "--scene", str(path))[2]
    )
    for words, said in ((("--environment",), "--environment needs a model: valid are mass-spring-damper"), (("--effect",), "--effect needs a model: valid are first-order-lag"),
                        (("--effect", "delay", "--effect"), "--effect needs a model"), (("--model", "x"), "--model: what is felt is --environment MODEL"),
                        (("--model",), "--model: what is felt is")):  # fmt: skip
        status, _, err = run("identify", "a.csv", *words)
        assert (status, said in err) == (2, True)


def test_a_simulation_is_run_as_the_words_say_and_its_force_and_status_follow(
    run: Run, asked: Any, mine: str, tmp_path: Path
) -> None:
    force, answer = tmp_path / "force.csv", Stub(agrees=True)
    seen = asked("haptisym.verbs.simulate.command.run", answer)
    assert run("simulate", mine, "--force", str(force)) == (0, PAGE, f"force written to {force}\n")
    assert force.read_text(encoding="utf-8") == "the run"
    answer.agrees = False
    assert run("simulate", mine, "--check", "--json")[:2] == (3, JSON)
    answer.agrees = None
    words = (
        "--motion",
        "chirp",
        "--amplitude",
        "1",
        "--omega",
        "2",
        "--duration",
        "3",
        "--quantise",
        "4",
        "--saturate",
        "5",
        "--lowpass",
        "6",
        "--lowpass-order",
        "8",
    )
    assert run("simulate", mine, *words)[0] == 0
    usual = {
        "kind": "sine",
        **dict.fromkeys(
            ("amplitude", "omega", "duration", "release", "hand", "quantise", "saturate", "lowpass", "lowpass_order")
        ),
    }
    given = dict(
        zip(
            ("kind", "amplitude", "omega", "duration", "quantise", "saturate", "lowpass", "lowpass_order"),
            words[1::2],
            strict=True,
        )
    )
    assert [x[0][:3] for x in seen] == [("Mine", False, usual), ("Mine", True, usual), ("Mine", False, usual | given)]


def test_a_hand_lets_go_as_the_words_say_and_what_does_not_agree_is_status_3(
    run: Run, asked: Any, mine: str, tmp_path: Path
) -> None:
    force, answer = tmp_path / "force.csv", Stub(agrees=None, sign_agrees=True)
    seen = asked("haptisym.verbs.simulate.release.release", answer)
    assert run("simulate", mine, "--release", "1 cm", "--force", str(force)) == (0, PAGE, f"force written to {force}\n")
    assert force.read_text(encoding="utf-8") == "the run"
    for agrees, sign, status in ((False, True, 3), (True, False, 3), (None, None, 0), (True, None, 0)):
        answer.agrees, answer.sign_agrees = agrees, sign
        assert run("simulate", mine, "--release", "1 cm", "--hand", "h", "--duration", "2 s")[0] == status
    (first, keys), (last, others) = seen[0], seen[-1]
    assert (first, keys["duration"]) == (("Mine", "1 cm", None), None)
    assert (last, others["duration"]) == (("Mine", "1 cm", "h"), "2 s")
    assert callable(keys["progress"])
    for option in ("--motion", "--amplitude", "--omega", "--quantise", "--saturate", "--lowpass"):
        assert (
            f"--release lets the hand go, {option} is about a hand that moves"
            in run("simulate", mine, "--release", "1", option, "2")[2]
        )
    assert "--release lets the hand go, --check is about" in run("simulate", mine, "--release", "1", "--check")[2]
    for words, said in (
        (("--hand", "h"), "--hand is about a hand that lets go: it needs --release"),
        (("--check", "--force", "x"), "--force writes one run in time"),
    ):
        assert said in run("simulate", mine, *words)[2]


def test_a_sweep_is_asked_for_each_path_once_and_told_what_is_kept(
    run: Run, asked: Any, mine: str, tmp_path: Path
) -> None:
    seen = asked("haptisym.verbs.sweep.entry.sweep", "the data")
    made = asked("haptisym.verbs.sweep.swept.Swept")
    out = tmp_path / "out.nc"
    assert run("sweep", mine, "--vary", "k=1:3:3", "--vary", "b=1:100:3:log", "--out", str(out))[0] == 0
    (arguments, keys), (shown, _) = seen[0], made[0]
    assert (arguments[0], list(arguments[1])) == ("Mine", ["k", "b"])
    assert [[float(x) for x in row] for row in arguments[1].values()] == [[1, 2, 3], pytest.approx([1, 10, 100])]
    assert keys["out"] == out
    assert shown == ("Mine", "the data", out)
    figure = tmp_path / "f.svg"
    assert run("sweep", mine, "--vary", "k=1:3:3", "--vary", "b=1:2:2", "--figure", str(figure)) == (
        0,
        PAGE,
        f"figure written to {figure}\n",
    )
    answer = Stub(certified=False)
    asked("haptisym.verbs.sweep.swept.Swept", answer)
    assert run("sweep", mine, "--vary", "k=1:3:3", "--json") == (3, JSON, "")

    def stopped(*_: Any, progress: Callable[..., None], **__: Any) -> None:
        progress(1200, 65_536)
        raise KeyboardInterrupt

    for words, kept in (((), "nothing is kept; with --out FILE.zarr the same command would go on from there"),
                        (("--out", str(out)), f"what is done is in {out}, and the same command goes on from there")):  # fmt: skip
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("haptisym.verbs.sweep.entry.sweep", stopped)
            assert run("sweep", mine, "--vary", "k=1:3:3", *words) == (
                130,
                "",
                f"\ninterrupted at 1,200 of 65,536 sets: {kept}\n",
            )


def test_what_is_interrupted_says_how_far_it_came(run: Run, mine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: Any, told: Callable[..., None], **__: Any) -> None:
        told(1, 4)
        raise KeyboardInterrupt

    monkeypatch.setattr("haptisym.verbs.tolerances.entry.tolerances", stopped)
    assert run("tolerances", mine) == (130, "", "\ninterrupted at 25 %: there is no answer\n")
    monkeypatch.setattr("haptisym.verbs.metrics.entry.metrics", lambda _: (_ for _ in ()).throw(KeyboardInterrupt))
    assert run("metrics", mine) == (130, "", "\ninterrupted: there is no answer\n")


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (hs.SceneError("x: no"), 2, "error: x: no\n"), (hs.UndecidedError("too near"), 3, "undecided: too near\n"),
        (FileNotFoundError(2, "No such file", "a.csv"), 2, "error: a.csv: No such file\n"), (click.UsageError("no option"), 2, "no option"),
        *((ModuleNotFoundError("No module", name=f"{x}.sub"), 2, f'error: {x} is missing: this needs pip install "haptisym[{extra}]"\n')
          for x, extra in _EXTRAS.items()),
    ],
)  # fmt: skip
def test_what_goes_wrong_has_its_status_and_its_sentence(
    run: Run, mine: str, monkeypatch: pytest.MonkeyPatch, error: Exception, status: int, said: str
) -> None:
    def broken(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr("haptisym.verbs.metrics.entry.metrics", broken)
    found = run("metrics", mine)
    assert found[:2] == (status, "")
    assert said in found[2]
    assert found[2] == said or isinstance(error, click.UsageError)


def test_what_nobody_foresaw_is_raised_again(mine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["haptisym", "metrics", mine])
    for error in (
        RuntimeError("new"),
        OSError(5, "io"),
        ModuleNotFoundError("x", name="unknown"),
        ModuleNotFoundError("x"),
    ):

        def broken(*_: Any, error: Exception = error, **__: Any) -> None:
            raise error

        monkeypatch.setattr("haptisym.verbs.metrics.entry.metrics", broken)
        if type(error) is OSError:  # without a name it is that of standard output
            with pytest.raises(SystemExit):
                main()
            continue
        with pytest.raises(type(error)) as again:
            main()
        assert again.value is error


def test_an_answer_is_handed_over_as_page_document_figure_proof_and_files(
    run: Run, asked: Any, mine: str, tmp_path: Path
) -> None:
    files = {name: tmp_path / name for name in ("f.svg", "p.json", "page.tex")}
    words = ("--figure", str(files["f.svg"]), "--certificate", str(files["p.json"]), "--latex", str(files["page.tex"]))
    answer = Stub()
    asked("haptisym.verbs.stability.entry.stability", answer)
    status, out, err = run("stability", mine, *words)
    assert (status, out) == (0, PAGE)
    assert (
        err
        == f"figure written to {files['f.svg']}\ncertificate written to {files['p.json']}\nLaTeX written to {files['page.tex']}\n"
    )
    assert [files[x].read_text(encoding="utf-8") for x in ("f.svg", "p.json", "page.tex")] == [
        "figure",
        "the proof",
        latex(answer.document()),
    ]
    answer.certified, answer.drawn = False, ""
    files["f.svg"].unlink()
    assert run("stability", mine, "--json", "--figure", str(files["f.svg"])) == (3, JSON, "no figure: it is empty\n")
    assert not files["f.svg"].exists()
    asked("haptisym.verbs.metrics.entry.metrics", answer)
    assert run("metrics", mine, "--to", "latex") == (3, piece(answer.document()) + "\n", "")
    assert run("metrics", mine, "--to", "text") == (3, PAGE, "")
    assert (
        run("metrics", mine, "--to", "latex", "--latex", str(files["page.tex"]))[2]
        == f"LaTeX written to {files['page.tex']}\n"
    )


def test_several_environments_are_asked_about_together_or_one_by_its_name(
    run: Run, asked: Any, limits: list[float | None], mine: str, tmp_path: Path
) -> None:
    seen, one = (
        asked("haptisym.verbs.family.entry.evaluate_all"),
        asked("haptisym.commands.evaluate.evaluate_scene", Stub(bandwidths=None)),
    )
    assert (
        run("evaluate", "palpation-device", "--digits", "9", "--regions", "--proportion", "0.8", "--limit", "5")[0] == 0
    )
    assert run("evaluate", mine, "--environments", "fu2019", "sidestick")[0] == 0
    [(family, keys), (others, usual)] = [(x[0], y) for x, y in seen]
    assert (list(family), keys) == (["fat", "muscle", "liver", "tumour"], {"regions": True, "proportion": "0.8"})
    assert (list(others), others.title, usual) == (
        ["fu2019", "sidestick"],
        "Mine",
        {"regions": False, "proportion": None},
    )
    assert [x[0][1] for x in seen] == [9, 15]
    assert limits == [5.0, 60.0]
    assert run("evaluate", "palpation-device", "--environment", "liver")[0] == 0
    assert run("evaluate", mine, "--environments", "fu2019", "--environment", "fu2019")[0] == 0
    assert [x[0][0].partition(": ")[2] for x in one][:1] == ["liver"]
    proof = tmp_path / "proof.json"
    assert run("evaluate", mine, "--certificate", str(proof)) == (0, PAGE, f"certificate written to {proof}\n")
    assert proof.read_text(encoding="utf-8") == "the proof"
    for option in ("--tolerance", "--certificate", "--response"):
        assert (
            f"{option} takes one environment: choose it with --environment NAME"
            in run("evaluate", "palpation-device", option, str(tmp_path / "x.csv"))[2]
        )


def test_of_a_measured_scene_nothing_is_asked_that_needs_formulas(run: Run, asked: Any, tmp_path: Path) -> None:
    scene = str(bench(tmp_path, "omega,real,imag\n2,93,30\n8,-30,120\n"))
    seen = asked("haptisym.verbs.measured.entry.judge")
    assert run("evaluate", scene, "--json") == (0, JSON, "")
    assert [type(x[0][0]) for x in seen] == [hs.MeasuredScene]
    for words in (("--digits", "9"), ("--environment", "x"), ("--tolerance", "1"), ("--regions",), ("--proportion", "0.8"), ("--response", str(tmp_path / "r.csv")),
                  ("--certificate", str(tmp_path / "p")), ("--limit", "3")):  # fmt: skip
        status, _, err = run("evaluate", scene, *words)
        assert (status, f"{words[0]} is about scenes of formulas, and this one is measured: leave it out" in err) == (
            2,
            True,
        )


def test_formulas_are_written_in_every_form_as_python_has_them(run: Run, mine: str, tmp_path: Path) -> None:
    scene = hs.load_scene(mine)
    numeric = replace(hs.derive(scene, ()), of=("dH",))
    assert run("derive", mine, "--numeric", "--of", "dH", "--to", "latex") == (0, numeric.to_latex(), "")
    assert run("derive", mine, "--numeric", "--of", "dH") == (0, str(numeric), "")
    kept = replace(hs.derive(scene, ("k",)), of=("dH", "H_env"))
    assert run("derive", mine, "--keep", "k", "--of", "dH", "--of", "H_env", "--to", "json") == (
        0,
        kept.to_json() + "\n",
        "",
    )
    assert run("derive", mine, "--numeric", "--of", "dH", "--json") == (0, numeric.to_json() + "\n", "")
    assert run("derive", mine, "--to", "c", "--numeric") == (0, hs.scene_code(scene, hs.Language.C, parameters=()), "")
    status, out, _ = run("derive", mine, "--of", "dH", "--to", "mathml")
    assert (status, out[:1], out[-1:]) == (0, "<", "\n")
    path = tmp_path / "d.tex"
    assert run("derive", mine, "--of", "dH", "--to", "octave", "--latex", str(path))[0] == 2
    assert run("derive", mine, "--to", "octave", "--latex", str(path))[2] == f"LaTeX written to {path}\n"


# The terminal.


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("width", [59, 60, 120])
def test_a_bar_comes_after_its_patience_says_how_far_it_came_and_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, width: int
) -> None:
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    monkeypatch.setenv("COLUMNS", str(width))
    with progress("sets") as told:
        told(1, 10)
        assert screen.getvalue() == ""  # it is soon done
    assert told.reached == "1 of 10 sets"
    monkeypatch.setattr("haptisym.commands.progress.PATIENCE", 0.0)
    with progress("sets") as told:
        told(10, 10)
        assert screen.getvalue() == ""  # nothing is left to wait for
        told(1, 10, "the first half")
        told(5, None, "the second half")
        assert told.bar is not None
        assert told.bar.tasks[0].total is None
        told(7, 10)
        told.bar.refresh()
        assert (told.bar.tasks[0].completed, told.bar.tasks[0].total) == (7, 10)
        assert len(told.bar.columns) == (5 if width >= 60 else 3)
        seen = screen.getvalue()
        assert "7 of 10 sets" in seen
    left = screen.getvalue()
    assert left.endswith("\x1b[2K") or "\x1b[?25h" in left
    told(8, 10)
    assert screen.getvalue() == left  # it does not come again
    monkeypatch.setattr("sys.stderr", io.StringIO())
    with progress() as told:
        told(1, 2)
        assert told.bar is None  # where nobody looks
        assert told.reached == "50 %"


def test_how_far_something_came_is_counted_in_its_unit_or_in_per_cent() -> None:
    sets, plain = ProgressBar("sets"), ProgressBar("")
    for done, total, one, other in ((1, 10, "1 of 10 sets", "10 %"), (1200, 65_536, "1,200 of 65,536 sets", "2 %"), (3, None, "3 sets", ""), (0, 0, "0 of 0 sets", "100 %"),
                                    (0.125, 1, "0.125 of 1 sets", "12 %"), (999.5, 1e4, "1,000 of 10,000 sets", "10 %"), (999.4, None, "999 sets", "")):  # fmt: skip
        sets(done, total)
        plain(done, total)
        assert (sets.reached, plain.reached) == (one, other)


def test_a_bar_is_gone_before_anything_is_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptisym.commands.progress.PATIENCE", 0.0)
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    quiet()  # of no call there is no bar
    with click.Context(click.Command("x")) as context, progress() as told:
        told(1, 2)
        assert told.bar is not None
        quiet()
        assert not told.seen
        assert not told.bar.live.is_started
        assert context.meta == {}

    def stopped() -> None:
        with progress() as own:
            own(1, 2)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"^ at 50 %: there is no answer$"):
        stopped()


def test_folders_and_files_that_cannot_be_written_are_told_before_the_work_begins(
    run: Run, mine: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, file = tmp_path / "locked", tmp_path / "old.svg"
    folder.mkdir()
    file.write_text("", encoding="utf-8")
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK or Path(path) not in (folder, file))
    for path, said in (
        (folder / "new.svg", "permission denied"),
        (file, "permission denied"),
        (tmp_path / "no" / "x.svg", f"there is no folder {tmp_path / 'no'}"),
    ):
        assert run("metrics", mine, "--figure", str(path)) == (
            2,
            "",
            f"error: figure: {path} cannot be written: {said}\n",
        )
    assert run("metrics", mine, "--latex", str(file)) == (
        2,
        "",
        f"error: latex: {file} cannot be written: permission denied\n",
    )


def test_standard_output_that_is_closed_and_a_full_disk_are_sentences(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("sys.stdout", None)
    with pytest.raises(hs.HaptisymError, match="standard output cannot be written: it is closed"):
        write("x")
    monkeypatch.setattr("sys.stderr", None)
    note("lost")
    with (
        pytest.raises(hs.HaptisymError, match=r"^force: .*x cannot be written: no space left on device$"),
        to_file("force", tmp_path / "x"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")


class Stream(io.TextIOWrapper):
    """What the terminal is, as far as anyone asks."""

    def __init__(self, *, terminal: bool) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8")
        self.terminal = terminal

    def isatty(self) -> bool:
        return self.terminal


@pytest.mark.parametrize(
    ("terminal", "variables", "encoding"),
    [
        (True, {"LC_ALL": "C"}, "ascii"), (True, {"LANG": "POSIX"}, "ascii"), (True, {"LC_CTYPE": "C", "LANG": "de_DE.UTF-8"}, "ascii"), (False, {"LC_ALL": "C"}, "utf-8"),
        (True, {"LC_ALL": "de_DE.UTF-8", "LANG": "C"}, "utf-8"), (True, {}, "utf-8"), (True, {"LC_ALL": "C", "PYTHONIOENCODING": "utf-8"}, "utf-8"),
        (True, {"LC_ALL": "C", "PYTHONUTF8": "1"}, "utf-8"),
    ],
)  # fmt: skip
def test_a_terminal_that_was_told_so_has_ascii_and_what_it_lacks_is_spelt(
    monkeypatch: pytest.MonkeyPatch,
    terminal: bool,  # noqa: FBT001
    variables: dict[str, str],
    encoding: str,
) -> None:
    for name in ("LC_ALL", "LC_CTYPE", "LANG", "PYTHONIOENCODING", "PYTHONUTF8"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    out, err = Stream(terminal=terminal), Stream(terminal=False)
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    prepare()
    assert (out.encoding, err.encoding) == (encoding, "utf-8")
    write("ω²")
    say_document('"ω"')
    plain = encoding == "ascii"
    assert out.buffer.getvalue().decode(encoding) == ('omega^2"\\u03c9"\n' if plain else 'ω²"ω"\n')  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("columns", "terminal", "width"), [("50", True, 50), ("300", True, 96), ("50", False, 96), ("96", True, 96)]
)
def test_a_page_is_as_wide_as_its_terminal_but_not_wider_than_96_columns(
    monkeypatch: pytest.MonkeyPatch,
    columns: str,
    terminal: bool,  # noqa: FBT001
    width: int,
) -> None:
    out = Stream(terminal=terminal)
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setenv("COLUMNS", columns)
    say(Document("A title", (), (Paragraph(("word " * 99,)),)))
    lines = out.buffer.getvalue().decode().splitlines()  # type: ignore[attr-defined]
    assert width - 5 < max(map(len, lines)) <= width


def test_an_output_without_an_encoding_takes_every_character(monkeypatch: pytest.MonkeyPatch) -> None:
    out = io.StringIO()
    monkeypatch.setattr("sys.stdout", out)
    say_document("ω")
    assert out.getvalue() == "ω\n"
    with pytest.raises(OSError, match="mine"), to_standard_output():
        raise OSError(errno.EIO, "mine", "a.csv")


def test_messages_are_as_wide_as_the_terminal_from_forty_to_96_columns_but_for_what_is_typed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words = "a message of many words " * 9
    for columns, width in ((10, 40), (40, 40), (70, 70), (96, 96), (300, 96)):
        screen = Terminal()
        screen.fileno = lambda: 2  # type: ignore[method-assign]
        monkeypatch.setattr("sys.stderr", screen)
        monkeypatch.setattr(os, "get_terminal_size", lambda _, columns=columns: os.terminal_size((columns, 24)))
        note(f"{words}\n    {words}")
        *told, typed = screen.getvalue().rstrip("\n").split("\n")
        assert typed == f"    {words}".rstrip("\n")
        assert width - 8 < max(map(len, told)) <= width
        assert " ".join(" ".join(told).split()) == words.strip()


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("x²", "x^2"), ("10⁻³", "10^-3"), ("x²³", "x^23"), ("²", "^2"), ("a₁₂", "a_1_2"), ("ω", "omega"), ("2ω", "2 omega"), ("(ω", "(omega"), ("Ω", "Omega"),
        ("aΓ", "a Gamma"), ("λ", "lambda"), ("ﬁ", "fi"), ("é", "e"), ("e\u0301", "e"), ("½", "\\u00bd"), ("振", "\\u632f"), ("😀", "\\U0001f600"), ("−≤≥≠±", "-<=>=!=+-"),
        ("√∞∂…", "sqrtinfd..."), ("ß", "ss"), ("§3", "section 3"), ("\u00a0", " "), ("plain", "plain"), ("°", "deg"), ("µ", "u"), ("Å", "A"),
    ],
)  # fmt: skip
def test_what_ascii_lacks_is_spelt(text: str, plain: str) -> None:
    assert spelt(text, "ascii") == plain
    assert spelt(text, "utf-8") == spelt(text, "no-such-encoding") == text


def test_documents_keep_every_character_in_the_escapes_of_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert escaped("aé😀ω", "ascii") == "a\\u00e9\\ud83d\\ude00\\u03c9"
    assert escaped("aéω", "latin-1") == "aé\\u03c9"
    assert escaped("aω", "utf-8") == escaped("aω", "no-such-encoding") == "aω"
    say_document("{}")
    say_document(["{", "}"])
    assert capsys.readouterr().out == "{}\n{}\n"


def test_documents_and_scenes_are_listed_and_printed_as_they_are(run: Run) -> None:
    status, out, err = run("schemas", "--json")
    rows = json.loads(out)
    assert (status, err, rows["schema"]) == (0, "", "haptisym.schemas/1")
    assert rows["schemas"] == [{"name": x, "description": json_schema(x)["description"]} for x in schema_names()]
    assert run("schemas", "evaluation") == (0, schema_text("evaluation").rstrip() + "\n", "")
    page = run("schemas")[1]
    assert page.startswith("Documents of --json")
    assert all(f"  {x}" in page for x in schema_names())
    assert "`" not in page
    for verb, name, told in (
        ("schemas", "evaluation", "--json lists the documents: a schema is JSON already"),
        ("scenes", "fu2019", "--json lists the scenes: a scene file is TOML"),
    ):
        assert told in run(verb, name, "--json")[2]
    assert run("scenes", "fu2019") == (
        0,
        (Path(hs.__file__).parent / "scenes" / "fu2019.toml").read_text(encoding="utf-8"),
        "",
    )


def test_every_verb_is_listed_once_and_helps(run: Run) -> None:
    status, out, _ = run("--help")
    listed = [x.split()[0] for x in out.partition("Commands:\n")[2].splitlines() if x.startswith("  ") and x[2] != " "]
    assert (status, listed) == (0, list(VERBS))
    assert run() == (0, out, "")
    assert run("-h")[1] == out
    assert run("--version") == (0, f"haptisym {hs.__version__}\n", "")
    assert sys.exc_info() == (None, None, None)
