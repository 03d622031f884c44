// The page: sends the scene to the worker as it is typed, and shows what comes back; its sliders are those of a report.
const find = (id) => document.getElementById(id);
const QUIET = 250; // ms without a change before the scene is asked about
const scene = find("scene");
const first = JSON.parse(find("first").textContent); // what the build computed: the scenes, and the answer about the one that the page shows
const { scenes } = first;
const about = new Map(["answer", "rest", "explorer-place"].map((id) => [id, scenes.fu2019])); // the text that each result is of
let [worker, ready, bytes] = [null, false, 0];
let [busy, waiting, last] = [null, [], 0]; // the question that is being answered, and the next ones: of each kind the latest alone

// Questions.

function start() {
  [ready, busy] = [false, null];
  find("loading").hidden = false;
  find("questions").disabled = true;
  worker = new Worker(new URL("worker.mjs", import.meta.url), { type: "module" });
  worker.onmessage = ({ data }) => {
    if ("share" in data) find("share").value = data.share;
    else if (data.words) said(data);
    else if (data.failed) say(`haptisym could not be loaded: ${data.failed}. The page needs a server: python -m http.server in its folder.`, "wrong");
    else if (data.ready) begin();
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

/** The program is there: what waits is answered, and what the build answered is answered again. */
function begin() {
  ready = true;
  find("loading").hidden = true;
  find("questions").disabled = false;
  find("megabytes").textContent = "";
  loaded(bytes);
  if (!waiting.length && !find("built").hidden) evaluate();
  next();
}

/** The bytes that were loaded here before, or are now: they are told once. */
function loaded(now = 0) {
  try {
    if (now) localStorage.setItem("haptisym", now);
    return Number(localStorage.getItem("haptisym"));
  } catch {
    return 0; // of a browser that stores nothing
  }
}

function say(text, kind = "") {
  find("said").textContent = text;
  find("said").className = kind;
}

/** Whether the scene cannot be answered as it is. */
function invalid(is) {
  if (is) scene.setAttribute("aria-invalid", "true");
  else scene.removeAttribute("aria-invalid");
}

/** These results are of this text; those of another one than is there say so. */
function mark(ids = [], text = "") {
  ids.forEach((id) => about.set(id, text));
  about.forEach((own, id) => find(id).classList.toggle("old", own !== scene.value));
  find("names").value = shipped() ?? "";
}

// The answer.

function put(id, html) {
  find(id).innerHTML = html;
  find(id).querySelectorAll(".scroll, .facts dd").forEach((x) => Object.assign(x, { tabIndex: 0 })); // to be scrolled by the keyboard
}

/** Ask about the text. `moved`: it was a slider that changed it, and so the sliders stay. */
function evaluate(moved = false) {
  const text = scene.value;
  mark(moved ? ["explorer-place"] : [], text);
  if (!ready) wait(text, moved);
  ask({ ask: "evaluate", scene: text, environment: find("environments").value }, (found, seconds) => {
    find("built").hidden = true;
    show(found);
    find("further").replaceChildren();
    mark(["answer", "rest", "further"], text);
    say(`Answered in ${seconds.toFixed(2)} s.`);
    if (!moved) explore(found.explorer, text);
  }, "Evaluating");
}

/** Until the program is there, what is shown is about the scene as it was; the figures follow their sliders. */
function wait(text, moved) {
  say(text === about.get("answer") ? "" : `It is answered as soon as the program is loaded. ${moved ? "The figures follow already, computed." : "What is shown is of the scene as it was."}`);
}

function show(found) {
  find("json").value = found.json;
  put("answer", found.lines);
  put("rest", found.html);
  choices(found);
}

function choices(found) {
  options("paths", found.paths);
  options("hands", [...found.hands, ""], { "": "the scene’s hands" });
  options("environments", found.environments);
  find("family").hidden = !found.environments.length;
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
  find("explorer-place").innerHTML = html;
  [...find("explorer-place").querySelectorAll("script:not([type])")].forEach((old) => {
    const fresh = document.createElement("script");
    fresh.textContent = old.textContent;
    old.replaceWith(fresh);
  });
  known(text);
}

/** Where the numbers of the sliders stand in the text. */
function known(text) {
  unmoved = text;
  mark(["explorer-place"], text);
  const { paths: places, sliders, limits } = JSON.parse(find("explorer-data").textContent);
  const first = places.filter(([id], i) => places.findIndex(([other]) => other === id) === i); // elsewhere it is referred to
  paths = [...first, ...limits.map((id) => [id, "evaluation", id === "explorer-c" ? "jnd" : id.replace(/^explorer-(c-)?/, "")])];
  units = new Map(sliders.map((slider) => [slider.id, slider.unit]));
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
  if (scene.value !== about.get("explorer-place")) return; // the sliders are of another scene
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
  note();
  if (scene.value !== about.get("explorer-place")) return mark(["explorer-place"], unmoved); // what was typed stays
  clearTimeout(resting);
  scene.value = unmoved; // with the units and all digits that were written there
  evaluate(true);
});
scene.addEventListener("input", () => {
  mark();
  soon(() => evaluate());
});
find("stop").addEventListener("click", stop);

// Further questions.

function below(html, text) {
  put("further", html);
  mark(["further"], text);
  if (document.activeElement !== scene) find("further").scrollIntoView({ block: "nearest" });
}

const further = (asked, words, text = scene.value) => ask({ ...asked, scene: text }, ({ html }, seconds) => {
  below(html, text);
  say(`Answered in ${seconds.toFixed(2)} s.`);
}, words);
const SOON = 3; // s after which the verdicts that are found so far are shown, and the limits are searched again with all the time
find("ask-stability").addEventListener("click", () => {
  const asked = { ask: "stability", scene: scene.value, hand: find("hands").value };
  ask({ ...asked, limit: SOON }, ({ html, partial }, seconds) => {
    below(html, asked.scene);
    if (partial) further(asked, html ? "The verdicts are below; searching the limits" : "Counting roots", asked.scene);
    else say(`Answered in ${seconds.toFixed(2)} s.`);
  }, "Counting roots");
});
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

/** The text of a link: a scene, or the name of one; empty without. */
function linked() {
  let given = location.hash.slice(1);
  try {
    given = decodeURIComponent(given);
  } catch {} // as it is
  if (!Object.hasOwn(scenes, given)) return given;
  return scenes[given];
}

/** The name of the shipped scene that the text is, if it is one. */
const shipped = () => Object.keys(scenes).find((x) => scenes[x] === scene.value);

async function copy(text, words) {
  find("copied").hidden = false;
  find("copied").textContent = text;
  mark(["copied"], scene.value);
  await navigator.clipboard?.writeText(text).catch(() => {}); // it is shown as well, for a browser that forbids this
  say(words);
}

/** A program that gives this answer. */
function asPython() {
  const [name, many] = [shipped(), /^\s*\[+\s*environments\b/m.test(scene.value)];
  const verb = many ? "evaluate_all" : "evaluate";
  const text = scene.value.replaceAll("\\", "\\\\").replaceAll('"""', '\\"\\"\\"');
  const given = name ? `"${name}"` : `hs.${many ? "parse_scenes" : "parse_scene"}(scene)`;
  return `import haptisym as hs\n\n${name ? "" : `scene = """\\\n${text}"""\n`}print(hs.${verb}(${given}))\n`;
}

/** Lines for a shell that give it. */
function asCommand() {
  const name = shipped();
  if (name) return `haptisym evaluate ${name}\n`;
  let end = "END";
  while (scene.value.split("\n").includes(end)) end += "_";
  return `cat > scene.toml <<'${end}'\n${scene.value.replace(/\n?$/, "\n")}${end}\nhaptisym evaluate scene.toml\n`;
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
  history.replaceState(null, "", `#${encodeURIComponent(shipped() ?? scene.value)}`);
  await navigator.clipboard?.writeText(location.href).catch(() => {});
  say("The link is in the address bar: it holds the scene, and nothing of it is sent to a server.");
});
find("as-python").addEventListener("click", () => copy(asPython(), "Copied: a program for Python with haptisym."));
find("as-command").addEventListener("click", () => copy(asCommand(), "Copied: lines for a shell with haptisym."));
addEventListener("hashchange", () => open(linked() || scenes.fu2019));
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  take(event.dataTransfer.files[0]);
});
fetch(new URL("packages.json", import.meta.url)).then((x) => x.json()).then(({ core, packages }) => {
  bytes = core + packages.reduce((sum, x) => sum + x.size, 0);
  if (loaded() !== bytes) find("megabytes").textContent = `, once, ${Math.round(bytes / 1e6)} MB`;
}).catch(() => {});
start();
const given = linked();
if (given) {
  open(given);
} else {
  scene.value = scenes.fu2019;
  find("json").value = first.found.json;
  choices(first.found);
  known(scene.value);
}
