// Archives as one of bytecode, compiled by the Python that will run it: node compile.mjs PYODIDE OUT ARCHIVE ...; OUT ends in .zip or .tar.zst.
import fs from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, out, ...archives] = process.argv.slice(2);
const { loadPyodide } = await import(pathToFileURL(`${folder}/pyodide.mjs`));
const python = await loadPyodide({ indexURL: `${folder}/`, args: ["-X", "no_debug_ranges"] });
archives.forEach((archive) => python.unpackArchive(new Uint8Array(fs.readFileSync(archive)), "zip", { extractDir: "/packages" }));
const made = python.runPython(`
import ast, io, marshal, tarfile, warnings, zipfile
from compression import zstd
from importlib.util import MAGIC_NUMBER
from pathlib import Path

warnings.simplefilter("ignore")
LEFT_OUT = {  # of what the page never imports: whole packages, and modules of the standard library
    *("sympy/" + x for x in "stats testing crypto holonomic diffgeom sandbox liealgebras benchmarks".split()),
    *("sympy/physics/" + x for x in "quantum mechanics biomechanics continuum_mechanics optics hep".split()),
    "flint/test", "haptisym/commands", "haptisym/benches", "haptisym/cli.py",
    *"email http xml xmlrpc unittest pydoc_data multiprocessing sqlite3 idlelib tkinter turtledemo lib2to3 wsgiref curses dbm venv ensurepip _pyrepl".split(),
    *(x + ".py" for x in "pdb doctest pydoc _pyio pickletools imaplib smtplib poplib ftplib mailbox turtle optparse".split()),
}
OWN = ("haptisym", "haptisym_check")  # whose docstrings are read at run time


def bytecode(path, inside):
    tree = ast.parse(path.read_bytes())
    for node in ast.walk(tree) if inside.parts[0] not in OWN else ():
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and ast.get_docstring(node, clean=False):
            node.body[0].value.value = ""
    return MAGIC_NUMBER + bytes(12) + marshal.dumps(compile(tree, str(inside), "exec", dont_inherit=True))


def files(top):
    for path in sorted(top.rglob("*")):
        inside = path.relative_to(top)
        names = {str(inside), *map(str, inside.parents)}
        unused = path.suffix == ".pyc" or (path.suffix in (".pyi", ".pxd", ".h") and inside.parts[0] not in OWN)
        if path.is_dir() or unused or names & LEFT_OUT or "tests" in inside.parts or ".dist-info" in str(inside):
            continue
        if path.suffix != ".py":
            yield str(inside), path.read_bytes()
        else:
            yield str(inside.with_suffix(".pyc")), bytecode(path, inside)


def packed(name):
    made = io.BytesIO()
    if name.endswith(".zip"):
        with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            for inside, data in files(Path("/packages")):
                archive.writestr(zipfile.ZipInfo(inside), data, zipfile.ZIP_DEFLATED, 9)
        return made.getvalue()
    with tarfile.open(fileobj=made, mode="w") as archive:
        for inside, data in files(Path("/packages")):
            entry = tarfile.TarInfo(inside)
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))
    options = {zstd.CompressionParameter.compression_level: 12, zstd.CompressionParameter.window_log: 25}
    return zstd.compress(made.getvalue(), options=options)


packed
`)(out);
fs.writeFileSync(out, made.toJs());
