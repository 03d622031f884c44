// The page: sends the scene to the worker as it is typed, and shows what comes back; its sliders are those of a report.
const find = (id) => document.getElementById(id);
const QUIET = 250; // ms without a change before the scene is asked about
const scene = find("scene");
let [worker, ready, scenes] = [null, false, {}];
let [busy, waiting, last] = [null, null, 0]; // the question that is being answered, and the next one: the latest alone

// Questions.

function start() {
  [ready, busy] = [false, null];
  find("loading").hidden = false;
  worker = new Worker(new URL("worker.mjs", import.meta.url), { type: "module" });
  worker.onmessage = ({ data }) => {
    if ("share" in data) find("share").value = data.share;
    else if (data.failed) say(`haptisym could not be loaded: ${data.failed}. The page needs a server: python -m http.server in its folder.`, "wrong");
    else if (data.ready) begin(data.found);
    else if (busy && data.id === busy.id) {
      const { then } = busy;
      finished();
      if (data.found.error) say(data.found.error, "wrong");
      else then(data.found, data.seconds);
      next();
    }
  };
  worker.onerror = (event) => say(`haptisym could not be loaded: ${event.message || "this browser cannot run it"}.`, "wrong");
}

function ask(asked, then, words) {
  waiting = { id: (last += 1), asked, then, words };
  next();
}

function next() {
  if (!ready || busy || !waiting) return;
  [busy, waiting] = [waiting, null];
  worker.postMessage({ id: busy.id, asked: busy.asked });
  busy.timer = setTimeout(() => {
    say(`${busy.words} …`);
    find("stop").hidden = false;
  }, 600);
}

function finished() {
  clearTimeout(busy.timer);
  find("stop").hidden = true;
  busy = null;
}

function stop() {
  worker.terminate();
  waiting = null;
  finished();
  say("Stopped. Python is loaded anew, from the browser's cache.");
  start();
}

function begin({ scenes: texts, hands }) {
  [ready, scenes] = [true, texts];
  find("loading").hidden = true;
  if (!find("names").options.length) {
    const names = Object.keys(scenes).sort((a, b) => (b === "fu2019") - (a === "fu2019"));
    find("names").append(...names.map((name) => new Option(name, name)));
    find("hands").prepend(...hands.map((name) => new Option(name, name, false, name === hands[0])));
    if (!scene.value) fromLink();
    else evaluate();
  }
  next();
}

function say(text, kind = "") {
  find("said").textContent = text;
  find("said").className = kind;
  if (kind === "wrong") scene.setAttribute("aria-invalid", "true");
  else scene.removeAttribute("aria-invalid");
  if (kind === "wrong") find("answer").className = "old";
}

// The answer.

function put(id, html) {
  find(id).innerHTML = html;
  find(id).querySelectorAll(".scroll, .facts dd").forEach((x) => Object.assign(x, { tabIndex: 0 })); // to be scrolled by the keyboard
}

/** Ask about the text. `moved`: it was a slider that changed it, and so the sliders stay. */
function evaluate(moved = false) {
  const text = scene.value;
  ask({ ask: "evaluate", scene: text }, (found, seconds) => {
    find("answer").className = "";
    find("json").value = found.json;
    put("rest", found.html);
    const all = find("rest").firstElementChild;
    const end = [...all.children].findIndex((x) => x.className === "findings") + 1;
    find("answer").replaceChildren(...[...all.children].slice(0, end)); // the rest below the figures
    find("further").replaceChildren();
    say(`Answered in ${seconds.toFixed(2)} s.`);
    const chosen = find("paths").value;
    find("paths").replaceChildren(...found.paths.map((path) => new Option(path, path, false, path === chosen)));
    if (!moved) explore(found.explorer);
  }, "Evaluating");
}

let [paths, units, sent] = [[], new Map(), new Map()]; // of the sliders: where their numbers stand, and what was written there

/** The report's explorer, whose scripts run when they are put in anew. */
function explore(html) {
  find("explorer").hidden = false;
  find("explorer-place").innerHTML = html;
  const { paths: places, sliders } = JSON.parse(find("explorer-data").textContent);
  const first = places.filter(([id], i) => places.findIndex(([other]) => other === id) === i); // elsewhere it is referred to
  paths = [...first, ...(find("explorer-c") ? [["explorer-c", "evaluation", "jnd"]] : [])];
  units = new Map(sliders.map((slider) => [slider.id, slider.unit]));
  [...find("explorer-place").querySelectorAll("script:not([type])")].forEach((old) => {
    const fresh = document.createElement("script");
    fresh.textContent = old.textContent;
    old.replaceWith(fresh);
  });
  sent = new Map(paths.map(([id]) => [id, find(`${id}-value`).value]));
}

/** The text with another number at a key of a table (or of the i-th effect, or of its parameters); null where it has none there. */
export function rewritten(text, place, key, number, unit) {
  const lines = text.split("\n");
  let [table, effects] = ["", -1];
  for (let i = 0; i < lines.length; i += 1) {
    const head = /^\s*\[+\s*([\w.]+)\s*\]+/.exec(lines[i]);
    if (head) {
      table = head[1];
      effects += table === "effects";
    } else if (table === place || (table === "effects" && effects === place)) {
      const found = new RegExp(`^(\\s*|\\s*parameters\\s*=\\s*\\{.*?[{,\\s])(${key}\\s*=\\s*)("[^"]*"|[-+\\d.eE_]+)`).exec(lines[i]);
      if (found) {
        const ascii = unit.replaceAll("·", "*").replaceAll("²", "^2");
        const value = found[3].startsWith('"') && unit ? `"${number} ${ascii}"` : number;
        lines[i] = found[1] + found[2] + value + lines[i].slice(found[0].length);
        return lines.join("\n");
      }
    }
  }
  return null;
}

/** What the boxes show that the text does not have yet goes into the text. */
function moved() {
  let text = scene.value;
  paths.forEach(([id, place, key]) => {
    const box = find(`${id}-value`);
    if (box.value === sent.get(id) || box.hasAttribute("aria-invalid")) return;
    text = rewritten(text, place, key, box.value, units.get(id)) ?? text;
    sent.set(id, box.value);
  });
  if (text === scene.value) return;
  scene.value = text;
  evaluate(true);
}

let resting = 0;
const soon = (run) => {
  clearTimeout(resting);
  resting = setTimeout(run, QUIET);
};
find("explorer").addEventListener("input", () => soon(moved));
find("explorer").addEventListener("click", ({ target }) => {
  if (target.id === "explorer-reset") soon(moved);
});
scene.addEventListener("input", () => soon(() => evaluate()));
find("stop").addEventListener("click", stop);

// Further questions.

const further = (asked, words) => ask({ ...asked, scene: scene.value }, (found, seconds) => {
  put("further", found.html);
  say(`Answered in ${seconds.toFixed(2)} s.`);
}, words);
find("ask-stability").addEventListener("click", () => further({ ask: "stability", hand: find("hands").value }, "Counting roots"));
find("ask-require").addEventListener("click", () => further({ ask: "require", path: find("paths").value }, "Proving for which values nothing is noticed, which may take a minute or two"));
find("ask-certificate").addEventListener("click", () => ask({ ask: "certificate", scene: scene.value }, ({ text }) => keep("certificate.json", text), "Writing the certificate"));

// Scenes as links and files.

function keep(name, text) {
  const link = Object.assign(document.createElement("a"), { download: name, href: URL.createObjectURL(new Blob([text])) });
  link.click();
  URL.revokeObjectURL(link.href);
  say(`Saved as ${name}.`);
}

function open(text) {
  scene.value = text;
  evaluate();
}

function fromLink() {
  const given = decodeURIComponent(location.hash.slice(1));
  if (given in scenes) find("names").value = given;
  open(scenes[given] ?? (given || scenes.fu2019));
}

function take(file) {
  file?.text().then((text) => {
    if (!text.trimStart().startsWith("{")) open(text);
    else ask({ ask: "checked", scene: scene.value, proof: text }, ({ said, proven }) => say(said, proven ? "proven" : "wrong"), "Checking the certificate");
  });
}

find("names").addEventListener("change", () => open(scenes[find("names").value]));
find("json").addEventListener("click", ({ target }) => keep("answer.json", target.value));
find("save").addEventListener("click", () => keep("scene.toml", scene.value));
find("open").addEventListener("change", ({ target }) => {
  take(target.files[0]);
  target.value = ""; // the same file may be chosen again
});
find("link").addEventListener("click", async () => {
  const name = Object.keys(scenes).find((x) => scenes[x] === scene.value);
  history.replaceState(null, "", `#${encodeURIComponent(name ?? scene.value)}`);
  await navigator.clipboard?.writeText(location.href).catch(() => {});
  say("The link is in the address bar: it holds the scene, and nothing of it is sent to a server.");
});
addEventListener("hashchange", fromLink);
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  take(event.dataTransfer.files[0]);
});
fetch(new URL("packages.json", import.meta.url)).then((x) => x.json()).then(({ core, packages }) => {
  find("megabytes").textContent = `${Math.round((core + packages.reduce((sum, x) => sum + x.size, 0)) / 1e6)} MB:`;
}).catch(() => {});
start();
