// Holds Python and answers questions, so that the page never freezes; the page ends it to stop a question.
import { loadPyodide } from "./pyodide/pyodide.mjs";
import { boot } from "./boot.mjs";

const base = new URL("./", import.meta.url).href;

/** A file's bytes; `part(n)`: n of them are there. */
async function read(name, part = () => {}) {
  const response = await fetch(base + name);
  if (!response.ok) throw new Error(`${name}: ${response.status}`);
  const pieces = [];
  let count = 0;
  for (const reader = response.body.getReader(); ;) {
    const { done, value } = await reader.read();
    if (done) return new Uint8Array(await new Blob(pieces).arrayBuffer());
    pieces.push(value);
    part((count += value.length));
  }
}

try {
  const { answer } = await boot({ load: loadPyodide, read, base, told: (share) => postMessage({ share }) });
  onmessage = ({ data: { id, asked } }) => {
    const began = performance.now();
    try {
      const found = answer(asked, (words) => postMessage({ id, words }));
      postMessage({ id, found, seconds: (performance.now() - began) / 1000 });
    } catch (error) {
      postMessage({ id, found: { error: `this should not happen: ${String(error.message).trim().split("\n").pop()}` } });
    }
  };
  postMessage({ ready: true, found: answer({ ask: "listed" }) });
} catch (error) {
  postMessage({ failed: String(error.message || error) });
}
