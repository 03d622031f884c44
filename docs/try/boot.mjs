// Python with haptisym, ready to be asked: the same in the worker of the page and in Node, where the tests compare its digits.

/** A function that answers a question. `load`: Pyodide's; `read(name)`: the bytes of a file beside this one; `told(share)`: how far it is. */
export async function boot({ load, read, base, told = () => {} }) {
  const decode = (bytes) => new TextDecoder().decode(bytes);
  const { core, packages } = JSON.parse(decode(await read("packages.json")));
  const whole = core + packages.reduce((sum, { size }) => sum + size, 0);
  const python = await load({ indexURL: `${base}pyodide/` });
  let done = core;
  for (const { name, size } of packages) {
    told(done / whole);
    python.FS.writeFile("/tmp/packed", await read(name, (part) => told((done + part) / whole)));
    python.runPython("import site, tarfile; tarfile.open('/tmp/packed', 'r:zst').extractall(site.getsitepackages()[0], filter='fully_trusted')");
    done += size;
  }
  told(1);
  python.runPython(decode(await read("answers.py")));
  const answer = python.globals.get("answer");
  return { python, answer: (asked, done) => JSON.parse(answer(JSON.stringify(asked), done)) };
}
