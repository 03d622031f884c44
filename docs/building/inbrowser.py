"""The page that runs haptisym in a browser, ``try/`` of the site, and the packages that it needs.

``python docs/building/inbrowser.py FOLDER`` fetches Pyodide from npm and the wheels from PyPI into a folder, once, and
compiles them, and what the page uses of the standard library, so that SymPy is loaded in 1 s and not in 7; and axe, by
which the tests judge whether everybody can use the page. A folder of other versions, or one that was interrupted, is made
anew. Where a registry is out of reach, or npm is missing, it says so and ends with status 69; whatever else goes wrong is
an error. A site that is built while HAPTISYM_BROWSER names that folder (``build/browser`` if it names none) holds the
page; without it the page says how. By itself:
``python docs/building/inbrowser.py FOLDER SITE`` writes SITE/try.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZipFile

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "try"
FOLDER = Path(os.environ.get("HAPTISYM_BROWSER") or ROOT / "build" / "browser")
PYODIDE, FLINT, AXE = "314.0.7", "0.9.0", "4.10.3"
PLATFORM = [
    "--platform", "pyemscripten_2026_0_wasm32", "--implementation", "cp", "--abi", "cp314", "--python-version", "314",
]  # fmt: skip
WHEELS = {f"python-flint=={FLINT}": PLATFORM, "sympy": [], "mpmath": []}
CORE = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "pyodide-lock.json")
STDLIB, PACKAGES = "python_stdlib.zip", "packages.tar.zst"
COMPILER = Path(__file__).with_name("compile.mjs")
MADE = "made.txt"
"""The file of a folder that says what its packages are made of; it is written last."""
MOST = 24_000_000
"""Bytes of the page."""


OUT_OF_REACH = 69
"""The exit status that says so, and nothing is wrong here (EX_UNAVAILABLE of sysexits.h)."""
_NETWORK = (
    "ENOTFOUND", "EAI_AGAIN", "ECONNREFUSED", "ECONNRESET", "ETIMEDOUT", "ENETUNREACH", "EHOSTUNREACH",
    "NewConnectionError", "ConnectTimeoutError", "ReadTimeoutError", "Failed to establish a new connection",
    "Temporary failure in name resolution",
)  # fmt: skip
"""What npm and pip print of a registry that does not answer. One that answers that there is no such version is an error."""


def download(words: list[str], folder: Path) -> str:
    """What a command that downloads prints; SystemExit with ``OUT_OF_REACH`` where its registry does not answer."""
    if not shutil.which(words[0]):
        print(f"{words[0]} is missing", file=sys.stderr)
        raise SystemExit(OUT_OF_REACH)
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        print(done.stdout, done.stderr, sep="", file=sys.stderr)
        raise SystemExit(OUT_OF_REACH if any(x in done.stdout + done.stderr for x in _NETWORK) else 1)
    return done.stdout


def fetch(folder: Path) -> None:
    """Fetch into a folder what is missing from it or is of other versions, and compile it."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, version in (("pyodide", PYODIDE), ("axe-core", AXE)):
        described = folder / name / "package.json"
        if described.is_file() and json.loads(described.read_text("utf-8"))["version"] == version:
            continue
        for old in (name, "package"):  # the second one, where an unpacking was interrupted
            shutil.rmtree(folder / old, ignore_errors=True)
        packing = ["npm", "pack", "--loglevel=error", f"{name}@{version}"]
        archive = folder / download(packing, folder).split()[-1]
        with tarfile.open(archive) as packed:
            packed.extractall(folder, filter="data")
        (folder / "package").rename(folder / name)
        archive.unlink()
    if not is_ready(folder):
        with TemporaryDirectory() as wheels:
            for name, platform in WHEELS.items():
                options = ["--quiet", "--no-deps", "--only-binary=:all:", *platform, "--dest", wheels]
                download([sys.executable, "-m", "pip", "download", *options, name], folder)
            (folder / MADE).unlink(missing_ok=True)
            compiled(folder, folder / STDLIB, [folder / "pyodide" / STDLIB])
            compiled(folder, folder / PACKAGES, sorted(Path(wheels).iterdir()))
            (folder / MADE).write_text(_made(), encoding="utf-8")


def is_ready(folder: Path) -> bool:
    """Return whether a folder holds what the page needs, of these versions and compiled as now."""
    made = folder / MADE
    return made.is_file() and made.read_text("utf-8") == _made()


def _made() -> str:
    return f"Pyodide {PYODIDE}, {', '.join(WHEELS)}, by\n{COMPILER.read_text('utf-8')}"


def compiled(folder: Path, target: Path, archives: list[Path]) -> None:
    """Write archives of Python as one of bytecode, by the Python of the page."""
    pyodide = (folder / "pyodide").resolve()
    subprocess.run(["node", COMPILER, pyodide, target.resolve(), *(x.resolve() for x in archives)], check=True)


def place(folder: Path, site: Path) -> None:
    """Write the page into ``site/try``: with the packages of a folder, or with how they are had."""
    target = site / "try"
    shutil.rmtree(target, ignore_errors=True)
    if not is_ready(folder):
        target.mkdir(parents=True)
        (target / "index.html").write_text(_without(), encoding="utf-8")
        return
    shutil.copytree(PAGE, target, ignore=shutil.ignore_patterns("__pycache__"))
    (target / "index.html").write_text(answered(), encoding="utf-8")
    shutil.copy(ROOT / "src" / "haptisym" / "data" / "report.css", target)
    (target / "pyodide").mkdir()
    for name in CORE:
        shutil.copy(folder / "pyodide" / name, target / "pyodide")
    shutil.copy(folder / STDLIB, target / "pyodide")
    shutil.copy(folder / PACKAGES, target)
    with TemporaryDirectory() as made:
        sources = Path(made) / "haptisym.zip"
        with ZipFile(sources, "w") as archive:
            for path in _sources():
                archive.write(path, path.relative_to(ROOT / "src"))
        compiled(folder, target / "haptisym.tar.zst", [sources])
    sizes = [{"name": x.name, "size": x.stat().st_size} for x in sorted(target.glob("*.tar.zst"))]
    core = sum(x.stat().st_size for x in (target / "pyodide").iterdir())
    (target / "packages.json").write_text(json.dumps({"core": core, "packages": sizes}), encoding="utf-8")
    whole = sum(x.stat().st_size for x in target.rglob("*") if x.is_file())
    if whole > MOST:
        raise SystemExit(f"{target}: {whole} bytes, at most {MOST}")


def _sources() -> Iterator[Path]:
    for package in ("haptisym", "haptisym_check"):
        for path in sorted((ROOT / "src" / package).rglob("*")):
            if path.is_file() and path.suffix != ".pyc":
                yield path


def answered() -> str:
    """Return the page with the paper's scene and its answer, which are there before Python is."""
    sys.path.insert(0, str(PAGE))
    import answers

    scenes = answers.listed()["scenes"]
    found = answers.evaluate(scenes["fu2019"])
    names = sorted(scenes, key=lambda name: (name != "fu2019", name))
    first = {"scenes": scenes, "found": {key: found[key] for key in ("json", "paths", "hands", "environments")}}
    filled = {
        "names": "".join(f"<option>{name}</option>" for name in names),
        "scene": "\n" + escape(scenes["fu2019"], quote=False),  # HTML drops the first line break of a text box
        "answer": found["lines"], "explorer": found["explorer"], "rest": found["html"],
        "first": json.dumps(first).replace("<", "\\u003c"),
    }  # fmt: skip
    text = (PAGE / "index.html").read_text(encoding="utf-8")
    for name, html in filled.items():
        text = text.replace(f"<!-- {name} -->", html)
    return text


def _without() -> str:
    """The page where there are no packages."""
    text = (PAGE / "index.html").read_text(encoding="utf-8")
    head = text.partition('<div id="columns">')[0]
    css = (ROOT / "src" / "haptisym" / "data" / "report.css").read_text(encoding="utf-8")
    head = head.replace(
        '<link rel="stylesheet" href="report.css">\n<link rel="stylesheet" href="try.css">', f"<style>{css}</style>"
    )
    commands = (
        "python docs/building/inbrowser.py build/browser\npython docs/building/inbrowser.py build/browser build/site"
    )
    told = f"<p>This site was built without the packages that run here. With Node and pip they are had by</p>\n<pre>{commands}</pre>\n"
    return head + told + "</main>\n</body>\n</html>\n"


if __name__ == "__main__":
    fetch(Path(sys.argv[1]))
    if len(sys.argv) > 2:
        place(Path(sys.argv[1]), Path(sys.argv[2]))
