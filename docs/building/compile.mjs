// Wheels as one archive of bytecode, compiled by the Python that will run it: node compile.mjs FOLDER WHEEL ...; it is FOLDER/packages.zip.
import fs from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, ...wheels] = process.argv.slice(2);
const { loadPyodide } = await import(pathToFileURL(`${folder}/pyodide/pyodide.mjs`));
const python = await loadPyodide({ indexURL: `${folder}/pyodide/` });
wheels.forEach((wheel) => python.unpackArchive(new Uint8Array(fs.readFileSync(wheel)), "wheel", { extractDir: "/packages" }));
python.runPython(`
import compileall, warnings, zipfile
from pathlib import Path
warnings.simplefilter("ignore")
compileall.compile_dir("/packages", quiet=2, legacy=True)
with zipfile.ZipFile("/packages.zip", "w", zipfile.ZIP_DEFLATED) as archive:
    for path in sorted(Path("/packages").rglob("*")):
        if path.is_file() and path.suffix != ".py" and "tests" not in path.parts and ".dist-info" not in str(path):
            archive.write(path, path.relative_to("/packages"))
`);
fs.writeFileSync(`${folder}/packages.zip`, python.FS.readFile("/packages.zip"));
