// The page: sends the scene to the worker as it is typed, and shows what comes back; its sliders are those of a report.
const find = (id) => document.getElementById(id);
const QUIET = 250; // ms without a change before the scene is asked about
const scene = find("scene");
let [worker, ready, scenes] = [null, false, {}];
let [busy, waiting, last] = [null, [], 0]; // the question that is being answered, and the next ones: of each kind the latest alone

// Questions.

function start() {
  [ready, busy] = [false, null];
  find("loading").hidden = false;
  worker = new Worker(new URL("worker.mjs", import.meta.url), { type: "module" });
  worker.onmessage = ({ data }) => {
    if ("share" in data) find("share").value = data.share;
    else if (data.words) said(data);
    else if (data.failed) say(`haptisym could not be loaded: ${data.failed}. The page needs a server: python -m http.server in its folder.`, "wrong");
    else if (data.ready) begin(data.found);
    else if (busy && data.id === busy.id) {
      const { then, asked } = busy;
      finished();
      if (asked.ask === "evaluate") invalid(Boolean(data.found.error));
      if (data.found.error) say(data.found.error, "wrong");
      else then(data.found, data.seconds);
      next();
    }
  };
  worker.onerror = (event) => say(`haptisym could not be loaded: ${event.message || "this browser cannot run it"}.`, "wrong");
}

function ask(asked, then, words) {
  waiting = [...waiting.filter((x) => x.asked.ask !== asked.ask), { id: (last += 1), asked, then, words }];
  next();
}

function next() {
  if (!ready || busy || !waiting.length) return;
  busy = waiting.shift();
  worker.postMessage({ id: busy.id, asked: busy.asked });
  const own = busy;
  busy.timer = setTimeout(() => {
    find("stop").hidden = false;
    said({ id: own.id, words: "" });
  }, 600);
}

/** How far a long question is. */
function said({ id, words }) {
  if (id === busy?.id && !find("stop").hidden) say(`${busy.words} … ${words}`);
}

function finished() {
  clearTimeout(busy.timer);
  find("stop").hidden = true;
  busy = null;
}

function stop() {
  worker.terminate();
  waiting = waiting.filter((x) => x.asked.ask === "evaluate");
  finished();
  say("Stopped. Python is loaded anew, from the browser's cache.");
  start();
}

function begin({ scenes: texts }) {
  [ready, scenes] = [true, texts];
  find("loading").hidden = true;
  if (!find("names").options.length) {
    const names = Object.keys(scenes).sort((a, b) => (b === "fu2019") - (a === "fu2019"));
    find("names").append(...names.map((name) => new Option(name, name)));
    if (!scene.value) fromLink();
    else evaluate();
  }
  next();
}

function say(text, kind = "") {
  find("said").textContent = text;
  find("said").className = kind;
}

/** Whether the scene cannot be answered as it is: what stands below it is then about another one. */
function invalid(is) {
  if (is) scene.setAttribute("aria-invalid", "true");
  else scene.removeAttribute("aria-invalid");
  ["answer", "rest", "explorer-place"].forEach((id) => { find(id).className = is ? "old" : ""; });
}

// The answer.

function put(id, html) {
  find(id).innerHTML = html;
  find(id).querySelectorAll(".scroll, .facts dd").forEach((x) => Object.assign(x, { tabIndex: 0 })); // to be scrolled by the keyboard
}

/** Ask about the text. `moved`: it was a slider that changed it, and so the sliders stay. */
function evaluate(moved = false) {
  const text = scene.value;
  ask({ ask: "evaluate", scene: text, environment: find("environments").value }, (found, seconds) => {
    find("json").value = found.json;
    put("rest", found.html);
    const all = find("rest").firstElementChild;
    const end = [...all.children].findIndex((x) => x.className === "findings") + 1;
    find("answer").replaceChildren(...[...all.children].slice(0, end)); // the rest below the figures
    find("further").replaceChildren();
    say(`Answered in ${seconds.toFixed(2)} s.`);
    options("paths", found.paths);
    options("hands", [...found.hands, ""], { "": "the scene’s hands" });
    options("environments", found.environments);
    find("family").hidden = !found.environments.length;
    if (!moved) explore(found.explorer, text);
  }, "Evaluating");
}

/** Put names into a list to choose from; what was chosen stays where it is still there. */
function options(id, names, shown = {}) {
  const chosen = find(id).value;
  const kept = names.includes(chosen) && find(id).options.length > 1 ? chosen : names[0];
  find(id).replaceChildren(...names.map((name) => new Option(shown[name] ?? name, name, false, name === kept)));
}

let [paths, units, sent, unmoved] = [[], new Map(), new Map(), ""]; // of the sliders: where their numbers stand, what was written there, and the text before

/** The report's explorer, whose scripts run when they are put in anew. */
function explore(html, text) {
  unmoved = text;
  find("explorer").hidden = false;
  find("explorer-place").innerHTML = html;
  const { paths: places, sliders, limits } = JSON.parse(find("explorer-data").textContent);
  const first = places.filter(([id], i) => places.findIndex(([other]) => other === id) === i); // elsewhere it is referred to
  paths = [...first, ...limits.map((id) => [id, "evaluation", id === "explorer-c" ? "jnd" : id.replace(/^explorer-(c-)?/, "")])];
  units = new Map(sliders.map((slider) => [slider.id, slider.unit]));
  [...find("explorer-place").querySelectorAll("script:not([type])")].forEach((old) => {
    const fresh = document.createElement("script");
    fresh.textContent = old.textContent;
    old.replaceWith(fresh);
  });
  note();
}

const note = () => {
  sent = new Map(paths.map(([id]) => [id, find(`${id}-value`).value]));
};

/** The text with another number at a key of a table (or of the i-th effect or environment, or of its parameters); null where it has none there. */
export function rewritten(text, place, key, number, unit, environment) {
  const lines = text.split("\n");
  const count = { effects: -1, environments: -1 };
  let table = "";
  for (let i = 0; i < lines.length; i += 1) {
    const head = /^\s*\[+\s*(\w+)(\.parameters)?\s*\]+/.exec(lines[i]);
    if (head) {
      table = head[1];
      if (table in count && !head[2]) count[table] += 1;
    }
    const own = table === place || (table === "effects" && count.effects === place) || (table === "environments" && place === "environment" && count.environments === environment);
    const within = own ? "(?:parameters|jnd)" : !table && place;
    if (!head && within !== false) {
      const found = new RegExp(`^(${own ? "\\s*|" : ""}\\s*${within}\\s*=\\s*\\{.*?[{,\\s])(${key}\\s*=\\s*)("[^"]*"|[-+\\d.eE_]+)`).exec(lines[i]);
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
  let [text, lost] = [scene.value, ""];
  paths.forEach(([id, place, key]) => {
    const box = find(`${id}-value`);
    if (box.value === sent.get(id) || box.hasAttribute("aria-invalid")) return;
    const found = rewritten(text, place, key, box.value, units.get(id), Math.max(0, find("environments").selectedIndex));
    if (found === null) lost = key;
    text = found ?? text;
    sent.set(id, box.value);
  });
  if (lost) say(`${lost}: the page did not find that number in the scene; write it there.`, "wrong");
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
  if (target.id !== "explorer-reset") return;
  clearTimeout(resting);
  note();
  scene.value = unmoved; // with the units and all digits that were written there
  evaluate(true);
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
find("ask-derive").addEventListener("click", () => further({ ask: "derive" }, "Deriving"));
find("environments").addEventListener("change", () => evaluate());
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
  let given = location.hash.slice(1);
  try {
    given = decodeURIComponent(given);
  } catch {} // as it is
  const shipped = Object.hasOwn(scenes, given);
  if (shipped) find("names").value = given;
  open(shipped ? scenes[given] : given || scenes.fu2019);
}

function take(file) {
  if (file && !/\.(toml|json|txt)$/i.test(file.name)) say(`${file.name}: the page takes scenes (.toml) and certificates (.json); measured responses are judged by haptisym evaluate on a computer.`, "wrong");
  else file?.text().then((text) => {
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
