"""Pages in a browser: the explorer draws what the program computes, and the page of the site answers as the program does."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any, ClassVar

import browser
import numpy as np
import pytest
import questions
from browser import Browser
from certificates import text_of
from click.testing import CliRunner
from explorers import typed, undrawn
from jnds import inline
from marks import required

import haptisym as hs
from haptisym.cli import app
from haptisym.model.scenefile import scene_text
from haptisym.pages.report import save

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]
E, F = hs.environments, hs.effects
JNDS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", "real": 0.1, "imag": 0.12, "tilt": 0.5},
    "diamond": {"shape": "diamond", "real": 0.1, "imag": 0.1},
    "polygon": {"shape": "polygon", "corners": [[0.1, 0], ["0.02 + omega/1000", 0.1], [-0.1, 0.05], [0, -0.1]]},
    "sides and floor": {"real": {"higher": 0.08, "lower": 0.12}, "imag": "0.08 + 0.004*omega", "floor": "5 N/m"},
}
"""Of the paper's example."""


def with_jnd(jnd: Any) -> str:
    return re.sub("jnd = .*", f"jnd = {inline(jnd)}", text_of("fu2019"))


@cache
def evaluated(name: str) -> hs.Evaluation:
    return hs.evaluate(hs.parse_scene(with_jnd(JNDS[name])) if name in JNDS else hs.load_scene(name))


@cache
def said(name: str) -> str:
    """The page but for its drawings, which take seconds."""
    return undrawn(evaluated(name))


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Browser]]:
    """Opens a page in Chromium, which is started once."""
    required("chromium", browser.program())
    file = tmp_path_factory.mktemp("pages") / "page.html"
    with browser.running() as opened:

        def show(text: str) -> Browser:
            file.write_text(text, encoding="utf-8")
            opened.look(1280)
            opened.open(file)
            return opened

        yield show


def drawn(opened: Browser, kind: str) -> np.ndarray:
    """The points of a curve of the explorer, in the data's own coordinates."""
    d = opened.value(f"document.querySelector('#explorer-panel path.{kind}').getAttribute('d')")
    return np.array([[float(x) for x in point.split()] for point in re.split("[ML]", d)[1:]])


def bands(opened: Browser) -> list[list[float]]:
    script = "[...document.querySelectorAll('#explorer-ratios rect.band')].map(x => [+x.getAttribute('x'), +x.getAttribute('width')])"
    return [[low, low + width] for low, width in opened.value(script)]


def says(opened: Browser, e: hs.Evaluation) -> None:
    """The explorer shades the proven bands, and finds the crossings in floats."""
    found = e.to_dict()
    assert bands(opened) == [pytest.approx(x, rel=1e-9, abs=1e-9) for x in found["transparent"]]
    told = opened.value("document.getElementById('explorer-crossings').textContent")
    assert re.findall(r"at ([\d.]*\d)", told) == [f"{c['omega']:.4g}" for c in found["crossings"]]
    assert opened.complaints() == []


def lines(opened: Browser) -> list[str]:
    """What stands next to the sliders of the scene's values, and of theirs."""
    return list(opened.value("[...document.querySelectorAll('.told p')].slice(0, 2).map(x => x.textContent)"))


@pytest.mark.core
def test_a_page_with_its_drawings_loads_without_a_complaint_asks_for_nothing_and_fits(
    shown: Any, tmp_path: Path
) -> None:
    save(evaluated("fu2019").document(), evaluated("fu2019").to_json(), tmp_path / "x.html")
    opened = shown((tmp_path / "x.html").read_text(encoding="utf-8"))
    assert opened.complaints() == []
    assert len(opened.requests()) == 1
    for width in (1280, 400, 320):
        opened.look(width)
        assert opened.value("document.documentElement.scrollWidth") <= width
        # A figure is as wide as the page at most; what is wider than that scrolls in its own box.
        assert opened.value("[...document.querySelectorAll('figure')].every(x => x.scrollWidth <= x.clientWidth)")
    colour = "getComputedStyle(document.body).backgroundColor"
    light = opened.value(colour)
    opened.look(1280, dark=True)
    assert opened.value(colour) != light
    opened.call("Emulation.setEmulatedMedia", media="print")
    assert opened.value("document.getElementById('explorer').offsetHeight") == 0
    assert opened.printed().startswith(b"%PDF")
    opened.call("Emulation.setEmulatedMedia", media="")


# The explorer

MOVED = {
    "fu2019": {"omega_n": 47.5, "zeta": 0.7, "m": 2.5},
    "wave-variable-link": {"tau": 0.035, "k": 210.0},
    "organ-tissue": {"alpha": 0.31, "tau": 0.0},
    "four-channel-teleoperation": {"Ks": 55.0, "tau": 0.03},
}


@pytest.mark.parametrize("name", [pytest.param("fu2019", marks=pytest.mark.core), *list(MOVED)[1:]])
def test_a_moved_slider_draws_what_python_computes(name: str, shown: Any) -> None:
    opened, scene = shown(said(name)), evaluated(name).scene
    names = [p.symbol.name for p in scene.parameters]
    before = drawn(opened, "ratio.real")
    for parameter, number in MOVED[name].items():  # SI; typed as the scene has them
        index = names.index(parameter)
        size = float(scene.parameters[index].shown_unit(scene.motion).size)
        typed(opened, f"explorer-{index}", f"{number / size:.12g}")
    real, imag = drawn(opened, "ratio.real"), drawn(opened, "ratio.imag")
    omega, (low, high) = real[:, 0] * float(scene.frequency.size), map(float, scene.band)
    assert (omega[0], omega[-1]) == (low, pytest.approx(high, rel=1e-15))
    assert (np.diff(omega) > 0).all()
    assert len(omega) > 250
    distortion = scene.symbolic_distortion()
    used = {x.name for x in distortion.free_symbols}
    given = {p.symbol.name: float(p.value) for p in scene.parameters} | MOVED[name]
    computed = distortion.compile()(omega, **{key: x for key, x in given.items() if key in used})
    inside = np.isfinite(computed.ratio_real) & (computed.ratio_real < 5)
    assert real[inside, 1] == pytest.approx(computed.ratio_real[inside], rel=1e-9, abs=1e-9)
    assert imag[inside, 1] == pytest.approx(computed.ratio_imag[inside], rel=1e-9, abs=1e-9)
    size = np.abs(computed.environment_real).max() + np.abs(computed.environment_imag).max()
    for system in ("environment", "perceived"):
        points = drawn(opened, f"system.{system}")
        for column, part in enumerate(("real", "imag")):
            assert points[:, column] == pytest.approx(getattr(computed, f"{system}_{part}"), rel=1e-9, abs=1e-9 * size)
    assert real.shape != before.shape or not np.allclose(real, before)


@pytest.mark.core
def test_the_explorer_says_what_a_scene_with_other_numbers_would(shown: Any) -> None:
    opened = shown(said("fu2019"))
    says(opened, evaluated("fu2019"))
    proven, computed = lines(opened)
    assert re.findall(r"at ([\d.]+)", proven) == [f"{float(c.omega):.4g}" for c in evaluated("fu2019").crossings]
    typed(opened, "explorer-3", "47.5")
    typed(opened, "explorer-c", "0.15")
    scene = text_of("fu2019").replace("80 rad/s", "47.5 rad/s").replace("jnd = 0.10", "jnd = 0.15")
    says(opened, hs.evaluate(hs.parse_scene(scene)))
    assert lines(opened)[0] == proven
    assert lines(opened)[1] != computed
    kept = drawn(opened, "ratio.real")
    typed(opened, "explorer-3", "-1")  # is not allowed, marked and not drawn
    assert opened.value("document.getElementById('explorer-3-value').getAttribute('aria-invalid')") == "true"
    assert np.array_equal(drawn(opened, "ratio.real"), kept)
    opened.value("document.getElementById('explorer-reset').click()")
    assert lines(opened) == [proven, computed]
    says(opened, evaluated("fu2019"))


OTHER: dict[str, tuple[dict[str, str], Any]] = {
    "ellipse": ({"explorer-c-real": "0.08", "explorer-tilt": "-0.3"}, JNDS["ellipse"] | {"real": 0.08, "tilt": -0.3}),
    "diamond": ({"explorer-c": "0.15"}, JNDS["diamond"] | {"real": 0.15, "imag": 0.15}),
    "polygon": ({"explorer-size": "1.5"}, {"shape": "polygon", "corners": [
        ["0.15", 0], ["0.03 + 3*omega/2000", "0.15"], ["-0.15", "0.075"], [0, "-0.15"]]}),
    "sides and floor": (
        {"explorer-c-real-lower": "0.1", "explorer-floor": "12"},
        JNDS["sides and floor"] | {"real": {"higher": 0.08, "lower": 0.1}, "floor": "12 N/m"},
    ),
}  # fmt: skip
"""What is typed, and the JND that has these numbers."""


@pytest.mark.parametrize("name", JNDS)
def test_the_explorer_draws_a_region_as_it_is_and_with_other_numbers(name: str, shown: Any) -> None:
    opened = shown(said(name))
    says(opened, evaluated(name))
    changes, other = OTHER[name]
    for identity, text in changes.items():
        typed(opened, identity, text)
    says(opened, hs.evaluate(hs.parse_scene(with_jnd(other))))


def noticed(name: str, x: float, y: float) -> bool:
    """Whether a change is noticed at 4 rad/s, where H_env of the paper's example is 71.2 + 60 j N/m."""
    if name == "ellipse":
        u, v = x / 0.1, y / 0.12
        return u * u - u * v + v * v > 0.75
    if name == "diamond":
        return abs(x) + abs(y) > 0.1
    if name == "polygon":
        corners = [(0.1, 0), (0.024, 0.1), (-0.1, 0.05), (0, -0.1)]
        sides = zip(corners, [*corners[1:], corners[0]], strict=True)
        return any((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) < 0 for a, b in sides)
    size = float(np.hypot(71.2, 60))
    limits = {True: (0.08, 0.096), False: (0.12, 0.096)}
    for i, (own, change) in enumerate(((71.2 / size, x), (60 / size, y))):
        if abs(change) > max(limits[abs(own + change) > abs(own)][i], 5 / size):
            return True
    return False


@pytest.mark.parametrize("name", JNDS)
def test_the_region_is_drawn_as_it_is_at_the_frequency_that_is_asked_about(name: str, shown: Any) -> None:
    """Just inside of each of its lines nothing is noticed, by the formulas of the region, just outside something is."""
    opened = shown(said(name))
    typed(opened, "explorer-omega", "4")
    listed = opened.value(
        "[...document.querySelectorAll('#explorer-region path.region')].map(x => x.getAttribute('d'))"
    )
    assert listed
    for d in listed:
        line = np.array([[float(x) for x in p.split()] for p in re.split("[ML]", d.rstrip("Z"))[1:]])
        middle = line.mean(axis=0)
        for p, q in zip(line, np.roll(line, -1, axis=0), strict=True):
            edge = (p + q) / 2
            assert not noticed(name, *(middle + 0.9999 * (edge - middle)))
            assert noticed(name, *(middle + 1.01 * (edge - middle)))


# The page that runs haptisym itself

IN_NODE = """
import fs from "node:fs";
const [site, witness, scenes] = [process.argv[1], process.argv[2], JSON.parse(process.argv[3])];
const { loadPyodide } = await import(`${site}/pyodide/pyodide.mjs`);
const { boot } = await import(`${site}/boot.mjs`);
const read = async (name) => new Uint8Array(fs.readFileSync(`${site}/${name}`));
const { python, answer } = await boot({ load: loadPyodide, base: `${site}/`, read });
python.FS.writeFile("questions.py", fs.readFileSync(witness, "utf8"));
const asked = python.runPython("import json, sys; sys.path.insert(0, '.'); import questions; lambda name: json.dumps(questions.answers(name))");
const found = {};
for (const [name, text, edited] of scenes) {
  const evaluated = answer({ ask: "evaluate", scene: text });
  const again = answer({ ask: "evaluate", scene: edited });
  found[name] = { json: evaluated.json, edited: again.json, answers: evaluated.environments.length ? {} : JSON.parse(asked(name)) };
}
process.stdout.write(JSON.stringify(found));
"""


@pytest.fixture(scope="module")
def packages() -> Path:
    """What the page needs, and axe."""
    if os.environ.get("HAPTISYM_BROWSER") == "none":
        pytest.skip("the packages could not be fetched")
    return Path(os.environ.get("HAPTISYM_BROWSER") or ROOT / "build" / "browser")


@pytest.fixture(scope="module")
def site(packages: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page and its packages, as the site has them."""
    required(f"{packages}, by python docs/building/inbrowser.py {packages},", (packages / "packages.tar.zst").is_file())
    built = tmp_path_factory.mktemp("site")
    subprocess.run([sys.executable, ROOT / "docs" / "building" / "inbrowser.py", packages, built], check=True)
    return built / "try"


def edited(text: str) -> str:
    """The scene with another threshold, and one more of a number of its environment."""
    changed = re.sub(r'(\[environments?\]+[^\[]*?= ")(\d+)', lambda x: f"{x[1]}{int(x[2]) + 1}", text, count=1)
    assert changed != text
    return changed


@pytest.mark.core
def test_every_shipped_scene_has_the_same_digits_in_webassembly(site: Path) -> None:
    node = shutil.which("node")
    required("node", node)
    texts = {name: scene_text(name)[0] for name in (*hs.scene_names(), *hs.family_names())}
    given = json.dumps([[name, text, edited(text)] for name, text in texts.items()])
    witness = Path(questions.__file__)
    done = subprocess.run(
        [str(node), "--input-type=module", "-e", IN_NODE, str(site), str(witness), given],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout)
    for name, text in texts.items():
        printed = CliRunner().invoke(app, ["evaluate", name, "--json"]).stdout
        assert told[name]["json"].strip() == printed.strip(), name
        is_family = name in hs.family_names()
        again = hs.evaluate_all if is_family else lambda scenes: hs.evaluate(scenes.first)
        assert told[name]["edited"] == again(hs.parse_scenes(edited(text))).to_json(), name
        assert told[name]["answers"] == ({} if is_family else questions.answers(name)), name


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The address of a folder's pages."""

    class Quiet(SimpleHTTPRequestHandler):
        extensions_map: ClassVar = {**SimpleHTTPRequestHandler.extensions_map, ".mjs": "text/javascript"}

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/index.html"
        server.shutdown()


@pytest.fixture(scope="module")
def tried(site: Path) -> Iterator[Browser]:
    """The page in Chromium, which has answered about the paper's scene."""
    required("chromium", browser.program())
    with browser.running() as opened, served(site) as address:
        opened.look(1280)
        opened.open(address)
        changed = text_of("fu2019").replace("0.10", "0.12")
        opened.value(f"(() => {{ {PUT.format(json.dumps(changed))} }})()")  # before the program is there
        until(opened, "document.getElementById('built').hidden")
        told = opened.value("document.getElementById('json').value")
        assert told == hs.evaluate(hs.parse_scene(changed)).to_json()
        yield opened


def until(opened: Browser, script: str, seconds: float = 120) -> Any:
    """The value of a script once it is something."""
    ended = time.monotonic() + seconds
    while time.monotonic() < ended:
        if found := opened.value(script):
            return found
        time.sleep(0.05)
    raise AssertionError(f"{script} is nothing: {words(opened, 'said')}; {opened.complaints()}")


def words(opened: Browser, identity: str) -> str:
    return str(opened.value(f"document.getElementById('{identity}').textContent"))


def do(opened: Browser, script: str, then: str) -> str:
    """What the page says after something was done: the words that begin so."""
    opened.value(f"(() => {{ document.getElementById('said').textContent = ''; {script} }})()")
    until(opened, f"document.getElementById('said').textContent.startsWith({json.dumps(then)})")
    return words(opened, "said")


CLICK = "document.getElementById('{}').click()"
PUT = "const box = document.getElementById('scene'); box.value = {}; box.dispatchEvent(new Event('input'))"


@pytest.fixture
def early(tmp_path: Path) -> Iterator[Browser]:
    """The page as the build writes it, whose program is never there."""
    required("chromium", browser.program())
    build = ROOT / "docs" / "building"
    written = f"import sys; sys.path.insert(0, {str(build)!r}); import inbrowser; print(inbrowser.answered())"
    done = subprocess.run([sys.executable, "-c", written], capture_output=True, check=True)
    (tmp_path / "index.html").write_bytes(done.stdout)
    for file in (*(ROOT / "docs" / "try").glob("try.*"), ROOT / "src" / "haptisym" / "data" / "report.css"):
        shutil.copy(file, tmp_path)
    (tmp_path / "worker.mjs").touch()
    (tmp_path / "packages.json").write_text('{"core": 0, "packages": []}', encoding="utf-8")
    with browser.running() as opened, served(tmp_path) as address:
        opened.look(1280)
        opened.open(address)
        yield opened


def test_the_page_has_an_answer_and_sliders_before_its_program_is_there(early: Browser) -> None:
    own = hs.evaluate("fu2019")
    assert early.value("document.getElementById('json').value") == own.to_json()
    assert early.value("document.getElementById('scene').value") == text_of("fu2019")
    assert "when this page was built" in words(early, "built")
    shown = re.sub(r"\W+", "", words(early, "answer"))
    for line in str(own).splitlines()[2:5]:
        assert re.sub(r"\W+", "", line) in shown
    says(early, own)
    ends = "[...document.querySelectorAll('#answer dd, .control')].map(x => x.getBoundingClientRect().bottom)"
    assert max(early.value(ends)) < 800
    assert early.value("document.getElementById('ask-require').matches(':disabled')")
    typed(early, "explorer-3", "47.5")
    changed = text_of("fu2019").replace("80 rad/s", "47.5 rad/s")
    until(early, "document.getElementById('answer').className === 'old'")
    assert early.value("document.getElementById('scene').value") == changed
    assert early.value("document.getElementById('explorer-place').className") == ""
    says(early, hs.evaluate(hs.parse_scene(changed)))
    early.value(f"(() => {{ {PUT.format(json.dumps(text_of('delayed-spring')))} }})()")
    until(early, "document.getElementById('explorer-place').className === 'old'")
    typed(early, "explorer-3", "60")
    time.sleep(0.5)  # until the page takes it for the end of the typing
    early.value(CLICK.format("explorer-reset"))
    assert early.value("document.getElementById('scene').value") == text_of("delayed-spring")
    assert early.value("document.getElementById('explorer-place').className") == "old"
    early.look(400)
    assert early.value("document.documentElement.scrollWidth") <= 400


@pytest.mark.parametrize("name", ["fu2019", "palpation-device"])
def test_what_is_copied_gives_the_same_answer(name: str, early: Browser, tmp_path: Path) -> None:
    text = scene_text(name)[0]
    family = name in hs.family_names()
    for scene in (text, f'# \\n """ \'\n{text}'):
        own = hs.evaluate_all(hs.parse_scenes(scene)) if family else hs.evaluate(hs.parse_scene(scene))
        early.value(f"(() => {{ {PUT.format(json.dumps(scene))} }})()")
        early.value(CLICK.format("as-python"))
        ran = subprocess.run([sys.executable, "-c", words(early, "copied")], capture_output=True, text=True, check=True)
        assert ran.stdout.split() == str(own).split()
    early.value(CLICK.format("as-command"))
    assert words(early, "copied").endswith("\nhaptisym evaluate scene.toml\n")
    foreign = f"{text}\nEND\ntouch wrong\n"  # a link from others must not run anything in a shell
    early.value(f"(() => {{ {PUT.format(json.dumps(foreign))} }})()")
    early.value(CLICK.format("as-command"))
    writing = words(early, "copied").removesuffix("haptisym evaluate scene.toml\n")
    subprocess.run(["bash", "-c", writing], cwd=tmp_path, check=True)
    assert (tmp_path / "scene.toml").read_text(encoding="utf-8") == foreign
    assert not (tmp_path / "wrong").exists()
    early.value(f"(() => {{ {PUT.format(json.dumps(text))} }})()")
    early.value(CLICK.format("as-command"))
    assert words(early, "copied") == f"haptisym evaluate {name}\n"


@pytest.mark.core
def test_the_page_answers_every_shipped_scene_as_the_command_line_does_and_asks_for_nothing_from_elsewhere(
    tried: Browser,
) -> None:
    for name in (*hs.scene_names(), *hs.family_names()):
        choose = f"const names = document.getElementById('names'); names.value = '{name}'; names.dispatchEvent(new Event('change'))"
        do(tried, choose, "Answered in")
        own = hs.evaluate_all(name) if name in hs.family_names() else hs.evaluate(name)
        assert tried.value("document.getElementById('json').value") == own.to_json(), name
    assert tried.complaints() == []
    assert {url.split("/")[2].partition(":")[0] for url in tried.requests() if not url.startswith("blob:")} == {
        "127.0.0.1"
    }


@pytest.mark.core
def test_a_slider_writes_its_number_into_the_scene_and_the_answer_follows(tried: Browser) -> None:
    do(tried, PUT.format(json.dumps(text_of("fu2019"))), "Answered in")
    typed(tried, "explorer-3", "47.5")
    scene = text_of("fu2019").replace("80 rad/s", "47.5 rad/s")
    until(
        tried, f"document.getElementById('json').value === {json.dumps(hs.evaluate(hs.parse_scene(scene)).to_json())}"
    )
    assert tried.value("document.getElementById('scene').value") == scene
    assert tried.value("document.activeElement.id") == "explorer-3-value"
    tried.value(CLICK.format("explorer-reset"))
    until(tried, f"document.getElementById('json').value === {json.dumps(hs.evaluate('fu2019').to_json())}")
    assert tried.value("document.getElementById('scene').value") == text_of("fu2019")


def test_a_slider_of_a_family_is_that_of_the_chosen_environment_and_so_is_each_limit_of_the_jnd(tried: Browser) -> None:
    text = scene_text("palpation-device")[0]
    do(tried, PUT.format(json.dumps(text)), "Answered in")
    choose = "const own = document.getElementById('environments'); own.value = 'muscle'; own.dispatchEvent(new Event('change'))"
    do(tried, choose, "Answered in")
    typed(tried, "explorer-0", "310")
    typed(tried, "explorer-c-real", "0.2")
    changed = text.replace('k = "290 N/m"', 'k = "310 N/m"').replace("real = 0.10", "real = 0.2")
    until(tried, f"document.getElementById('scene').value === {json.dumps(changed)}")
    typed(tried, "explorer-2", "79.6")  # the amplifier, in Hz as the scene has it
    until(tried, "document.getElementById('scene').value.includes('79.6 Hz')")
    tried.value(CLICK.format("explorer-reset"))
    until(
        tried, f"document.getElementById('json').value === {json.dumps(hs.evaluate_all('palpation-device').to_json())}"
    )
    assert tried.value("document.getElementById('scene').value") == text


@pytest.mark.core
def test_the_page_says_what_is_wrong_answers_further_questions_and_checks_certificates(
    tried: Browser, tmp_path: Path
) -> None:
    wrong = text_of("fu2019").replace("zeta = 0.5", "zeta = -1")
    do(tried, PUT.format(json.dumps(wrong)), 'scene: effects[1] "filter": second-order-lowpass needs zeta >= 0')
    assert tried.value("document.getElementById('scene').getAttribute('aria-invalid')") == "true"
    do(tried, PUT.format(json.dumps(text_of("fu2019"))), "Answered in")
    do(tried, CLICK.format("ask-stability"), "Answered in")
    assert "postural-arm" in words(tried, "further")
    for path, said in (("filter.zeta", "0 ≤ ζ ≤ 0.2643"), ("filter.omega_n", "ω_n ≥ 122.4")):
        choose = f"document.getElementById('paths').value = 'effects.{path}';"
        do(tried, choose + CLICK.format("ask-require"), "Answered in")
        assert said in words(tried, "further").replace("ωn", "ω_n")
    do(tried, CLICK.format("ask-derive"), "Answered in")
    assert "by exact algebra" in words(tried, "further")
    do(tried, PUT.format(json.dumps(wrong)), "scene:")
    assert tried.value("document.querySelectorAll('#answer.old, #rest.old, #further.old').length") == 3
    do(tried, PUT.format(json.dumps(text_of("fu2019"))), "Answered in")
    assert not tried.value("document.querySelector('.old')")
    proof = tmp_path / "proof.json"
    for text, said in ((hs.evaluate("fu2019").certificate(), "Proven"), ("{}", "NOT proven")):
        proof.write_text(text, encoding="utf-8")
        tried.value("document.getElementById('said').textContent = ''")
        tried.choose("#open", proof)
        until(tried, f"document.getElementById('said').textContent.startsWith('{said}')")


def test_a_long_question_tells_how_far_it_is_and_is_stopped_and_what_was_typed_meanwhile_is_answered(
    tried: Browser,
) -> None:
    do(tried, PUT.format(json.dumps(text_of("four-channel-teleoperation"))), "Answered in")
    path = "document.getElementById('paths').value = 'effects.teleoperator.Ms';"
    do(tried, path + CLICK.format("ask-require"), "Proving")
    until(tried, r"/\d+ of \d+ cells of values/.test(document.getElementById('said').textContent)")
    tried.value(f"(() => {{ {PUT.format(json.dumps(text_of('delayed-spring')))} }})()")
    time.sleep(0.5)  # until the page takes it for the end of the typing
    do(tried, CLICK.format("stop"), "Answered in")
    assert tried.value("document.getElementById('json').value") == hs.evaluate("delayed-spring").to_json()


def test_a_link_opens_its_scene_and_a_broken_one_is_a_scene_that_is_wrong(tried: Browser) -> None:
    scene = text_of("fu2019").replace("80 rad/s", "75 rad/s") + "# 100 %\n"
    do(tried, PUT.format(json.dumps(scene)), "Answered in")
    do(tried, CLICK.format("link"), "The link is in the address bar")
    link = tried.value("location.href")
    do(tried, PUT.format(json.dumps(text_of("delayed-spring"))), "Answered in")
    tried.open("about:blank")
    tried.open(link)
    until(tried, "document.getElementById('json').value")
    assert tried.value("document.getElementById('scene').value") == scene
    do(tried, "location.hash = '#100%'", "scene: not valid TOML")


def test_the_page_fits_a_telephone_and_the_dark_and_axe_finds_nothing_wherever_it_stands(
    tried: Browser, packages: Path
) -> None:
    axe = packages / "axe-core" / "axe.min.js"
    required(f"{axe}, by python docs/building/inbrowser.py {packages},", axe.is_file())
    tried.call("Runtime.evaluate", expression=axe.read_text(encoding="utf-8"))
    faults = "axe.run(document).then((x) => x.violations.map((y) => `${y.id}: ${y.nodes[0].target}`))"
    colour, colours = "getComputedStyle(document.body).backgroundColor", set()
    for text, then in ((scene_text("palpation-device")[0], "Answered in"), ("wrong", "scene: not valid TOML")):
        do(tried, PUT.format(json.dumps(text)), then)
        for width, dark in ((1280, False), (400, True), (400, False)):
            tried.look(width, dark=dark)
            colours.add(tried.value(colour))
            assert tried.value("document.documentElement.scrollWidth") <= width
            assert tried.value(faults) == []
    assert len(colours) == 2
