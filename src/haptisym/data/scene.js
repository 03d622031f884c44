// A scene's file as the checker of certificates reads it: written from docs/scenes.md and docs/certificates.md, with nothing from elsewhere.
// `catalogue` lists the units and models that are understood; whatever is not understood is refused. No number here is a float.
//
// A scene is rational: it has no delay, no clock and no power of s that is not whole.
const haptisymScene = (function () {
  "use strict";

  class Refused extends Error {}

  function need(condition, why) {
    if (!condition) throw new Refused(why);
  }

  // Exact fractions.

  const size = (n) => (n < 0n ? -n : n);
  const signOf = (n) => (n > 0n ? 1 : n < 0n ? -1 : 0);
  const sum = (list) => list.reduce((x, y) => x + y, 0n);

  /** Binary digits; none of 0. */
  function bitsOf(n) {
    const text = size(n).toString(16);
    return 4 * text.length - Math.clz32(parseInt(text[0], 16)) + 28;
  }

  const wordsOf = (n) => Math.ceil(bitsOf(n) / 64);
  const MOST_WORDS = 500;

  function divisor(a, b) {
    [a, b] = [size(a), size(b)];
    while (b) [a, b] = [b, a % b];
    return a;
  }

  class Fraction {
    constructor(n, d = 1n) {
      need(d !== 0n, "a division by zero");
      const by = (d < 0n ? -1n : 1n) * (divisor(n, d) || 1n);
      [this.n, this.d] = [n / by, d / by];
    }
    plus(x) { return new Fraction(this.n * x.d + x.n * this.d, this.d * x.d); }
    minus(x) { return new Fraction(this.n * x.d - x.n * this.d, this.d * x.d); }
    times(x) { return new Fraction(this.n * x.n, this.d * x.d); }
    over(x) { return new Fraction(this.n * x.d, this.d * x.n); }
    power(k) { return k >= 0 ? new Fraction(this.n ** BigInt(k), this.d ** BigInt(k)) : new Fraction(this.d, this.n).power(-k); }
    compare(x) { return signOf(this.n * x.d - x.n * this.d); }
  }

  const ZERO = new Fraction(0n);
  const ONE = new Fraction(1n);

  /** A number of a scene file: digits, a point, an exponent of ten of at most three digits. */
  function decimal(text) {
    const found = /^([+-]?)([0-9]*)(?:\.([0-9]*))?(?:[eE]([+-]?[0-9]{1,3}))?$/.exec(text);
    need(found && (found[2] || found[3]) && text.length < 4200, `${text.slice(0, 40)} is not understood`);
    const tail = found[3] || "";
    const whole = new Fraction(BigInt(`${found[2]}${tail}`) * (found[1] === "-" ? -1n : 1n));
    return whole.times(new Fraction(10n).power(Number(found[4] || 0) - tail.length));
  }

  // TOML, as far as scene files are usually written in it; anything else is refused.

  const ESCAPES = { '"': '"', "\\": "\\", b: "\b", t: "\t", n: "\n", f: "\f", r: "\r" };

  function toml(source) {
    let at = 0;
    const text = source.replace(/^\ufeff/, "").replace(/\r\n/g, "\n");
    const root = new Map();
    const closed = new Set();
    const fail = () => need(false, `line ${text.slice(0, at).split("\n").length} of the scene is not understood`);
    const take = (pattern) => {
      const found = new RegExp(pattern.source, "uy");
      found.lastIndex = at;
      const match = found.exec(text);
      if (match) at += match[0].length;
      return match;
    };
    const must = (pattern) => take(pattern) || fail();
    const blank = () => take(/(?:[ \t]|\n|#[^\n]*)*/);
    const space = () => take(/[ \t]*/);

    function string() {
      const found = take(/"(?!"")((?:[^"\\\n\u0000-\u0008\u000b-\u001f\u007f]|\\["\\btnfr]|\\u[0-9a-fA-F]{4}|\\U[0-9a-fA-F]{8})*)"/) || take(/'(?!'')([^'\n\u0000-\u0008\u000b-\u001f\u007f]*)'/);
      if (!found) return null;
      if (found[0][0] === "'") return found[1];
      return found[1].replace(/\\(?:u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|(.))/gu, (_, short, long, other) => (other ? ESCAPES[other] : String.fromCodePoint(parseInt(short || long, 16))));
    }

    /** The keys before the last, and the last. */
    function key() {
      const path = [];
      do {
        space();
        const bare = take(/[A-Za-z0-9_-]+/);
        const name = bare ? bare[0] : string();
        if (name === null) fail();
        path.push(name);
        space();
      } while (take(/\./));
      return [path, path.pop()];
    }

    /** The table of a path from a table on; of a list of tables the last one. */
    function inside(table, path) {
      return path.reduce((x, name) => {
        if (!x.has(name)) x.set(name, new Map());
        const found = x.get(name);
        const next = Array.isArray(found) ? found[found.length - 1] : found;
        if (!(next instanceof Map) || closed.has(next) || (Array.isArray(found) && closed.has(found))) fail();
        return next;
      }, table);
    }

    function pair(table) {
      const [path, last] = key();
      must(/=/);
      const target = inside(table, path);
      if (target.has(last)) fail();
      space();
      target.set(last, value(0));
    }

    function value(depth) {
      need(depth < 50, "the scene is nested too deeply");
      const told = string();
      if (told !== null) return told;
      if (take(/\[/)) return list(depth);
      if (take(/\{/)) return inline();
      const number = must(/[+-]?(?:0|[1-9](?:_?[0-9])*)(\.[0-9](?:_?[0-9])*)?([eE][+-]?[0-9]{1,3})?(?![\w.:-])/);
      const found = decimal(number[0].replace(/_/g, ""));
      return number[1] || number[2] ? found : { whole: found };
    }

    function list(depth) {
      const found = [];
      closed.add(found);
      for (blank(); !take(/\]/); blank()) {
        found.push(value(depth + 1));
        blank();
        if (take(/,/)) continue;
        must(/\]/);
        break;
      }
      return found;
    }

    function inline() {
      const table = new Map();
      space();
      if (!take(/\}/)) {
        do pair(table); while (space() && take(/,/));
        must(/\}/);
      }
      closed.add(table);
      return table;
    }

    let here = root;
    for (blank(); at < text.length; blank()) {
      const opened = take(/\[\[?/);
      if (!opened) pair(here);
      else {
        const [path, last] = key();
        const above = inside(root, path);
        if (opened[0] === "[[") {
          if (!above.has(last)) above.set(last, []);
          if (!Array.isArray(above.get(last)) || closed.has(above.get(last))) fail();
          above.get(last).push(new Map());
          must(/\]\]/);
        } else {
          if (above.has(last)) fail();
          must(/\]/);
        }
        here = inside(above, [last]);
      }
      must(/[ \t]*(?:#[^\n]*)?(?:\n|$)/);
    }
    return root;
  }

  // Values: Gaussian integers, each that of a polynomial, with bounds on its degrees in s (or omega) and in pi.

  const value = (re, im = 0n, degrees = [0, 0]) => ({ re, im, degrees });
  const plus = (x, y, sign = 1n) => value(x.re + sign * y.re, x.im + sign * y.im, x.degrees.map((n, i) => Math.max(n, y.degrees[i])));
  const times = (x, y) => value(x.re * y.re - x.im * y.im, x.re * y.im + x.im * y.re, x.degrees.map((n, i) => n + y.degrees[i]));
  const conjugate = (x) => ({ ...x, im: -x.im });
  const UNIT = value(1n);
  const NOTHING = value(0n, 0n, [-1e6, -1e6]);

  /** x + y, x - y, x * y or x / y of pairs of numerator and denominator. */
  function combined(sign, x, y) {
    need([...x, ...y].reduce((n, v) => n + wordsOf(v.re) + wordsOf(v.im), 0) < MOST_WORDS, "a number is too large");
    if (sign === "*") return [times(x[0], y[0]), times(x[1], y[1])];
    if (sign === "/") return [times(x[0], y[1]), times(x[1], y[0])];
    return [plus(times(x[0], y[1]), times(y[0], x[1]), sign === "+" ? 1n : -1n), times(x[1], y[1])];
  }

  // Formulas.

  const TOKEN = /((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)|([\p{L}\p{Nl}_][\p{L}\p{N}_]*|[°%])|(\*\*|[-+*\/^()])|\s+/uy;

  function parsed(text) {
    const why = `${text.slice(0, 60)} is not understood`;
    need(text.length <= 4000, why);
    const tokens = [];
    for (TOKEN.lastIndex = 0; TOKEN.lastIndex < text.length; ) {
      const found = TOKEN.exec(text);
      need(found, why);
      if (found[0].trim()) tokens.push(found);
    }
    let at = 0;
    const sign = (...which) => (at < tokens.length && tokens[at][3] && which.includes(tokens[at][3]) ? tokens[at++][3] : "");
    const chain = (inner, ...signs) => {
      let tree = inner();
      for (let s = sign(...signs); s; s = sign(...signs)) tree = [s, tree, inner()];
      return tree;
    };
    const sums = () => chain(() => chain(signed, "*", "/"), "+", "-");
    function signed() {
      const s = sign("+", "-");
      return s ? [s, "0", signed()] : power();
    }
    function power() {
      const isInner = sign("(");
      need(isInner || (at < tokens.length && !tokens[at][3]), why);
      const tree = isInner ? sums() : tokens[at++][0];
      need(!isInner || sign(")"), why);
      if (!sign("^", "**")) return tree;
      const bracket = sign("(");
      const minus = sign("+", "-") === "-";
      need(at < tokens.length && /^[0-9]{1,2}$/.test(tokens[at][0]), why);
      const n = Number(tokens[at++][0]);
      need((!bracket || sign(")")) && !sign("^", "**"), why);
      return ["^", tree, minus ? -n : n];
    }
    const tree = sums();
    need(at === tokens.length, why);
    return tree;
  }

  function evaluated(tree, leaf, combine) {
    if (typeof tree === "string") return leaf(tree);
    if (tree[0] !== "^") return combine(tree[0], evaluated(tree[1], leaf, combine), evaluated(tree[2], leaf, combine));
    const base = evaluated(tree[1], leaf, combine);
    let result = leaf("1");
    for (let k = 0; k < Math.abs(tree[2]); k += 1) result = combine(tree[2] > 0 ? "*" : "/", result, base);
    return result;
  }

  // Quantities: value * pi^pi, and powers of kg, m and s (null without a unit).

  const PARTS = ["real", "imag"];
  const quantityOf = (x, pi = 0, dimension = null) => ({ value: x, pi, dimension });

  /** A parameter that is left free takes the place of pi. */
  const FREE = Object.freeze(quantityOf(ONE, 1));

  function at(x, pi) {
    const [up, down] = [Math.max(x.pi, 0), Math.max(-x.pi, 0)];
    const top = x.value.n ? value(x.value.n * pi ** BigInt(up), 0n, [0, up]) : NOTHING;
    return [top, value(x.value.d * pi ** BigInt(down), 0n, [0, down])];
  }

  const factorial = (n) => (n > 1 ? BigInt(n) * factorial(n - 1) : 1n);
  const own = (table, name) => Object.prototype.hasOwnProperty.call(table, name);

  /** A list of tables, of a file. */
  function tables(x) {
    need(Array.isArray(x) && x.length <= 100 && x.every((y) => y instanceof Map), "a list of at most 100 tables is none");
    return x;
  }

  function reader(catalogue) {
    function unit(name) {
      const isWhole = own(catalogue.units, name);
      const [prefix, base] = isWhole ? ["", name] : [name.slice(0, 1), name.slice(1)];
      need(own(catalogue.units, base) && (!prefix || (own(catalogue.prefixes, prefix) && catalogue.units[base][3])), `the unit ${name.slice(0, 40)} is not understood`);
      const [factor, pi, dimension] = catalogue.units[base];
      const [n, d] = factor.split("/");
      const scale = new Fraction(10n).power(prefix ? catalogue.prefixes[prefix] : 0);
      return quantityOf(new Fraction(BigInt(n), BigInt(d || 1)).times(scale), pi, dimension);
    }

    function units(sign, x, y) {
      need(sign === "*" || sign === "/", "a unit is a product of powers");
      const n = sign === "*" ? 1 : -1;
      return quantityOf(x.value.times(y.value.power(n)), x.pi + n * y.pi, x.dimension.map((k, i) => k + n * y.dimension[i]));
    }

    /** Whether a quantity is of a kind; of an empty list any may be. */
    const isOf = (kind, { dimension }) => !kind.length || kind.some((d) => d.every((k, i) => k === dimension[i]));

    function quantity(given, kind) {
      if (Array.isArray(given)) {
        need(given.length === 2 || given.length === 3, "a range has two ends, and perhaps its nominal value between them");
        const [low, ...more] = given.map((x) => quantity(x, kind));
        const high = more[more.length - 1];
        need(low.pi === high.pi && String(low.dimension) === String(high.dimension), "the ends of a range have different units");
        return more.length === 2 ? more[0] : { ...low, value: low.value.plus(high.value).over(new Fraction(2n)) };
      }
      if (given === FREE) return FREE;
      if (given instanceof Fraction) return quantityOf(given);
      if (given && given.whole) return quantityOf(given.whole);
      need(typeof given === "string" && given.length < 500, "a value is neither a number nor a text");
      const [text, ...deviation] = given.split(/\+\/?-|±/);
      const found = /^\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)(?:\s*\/\s*([0-9]+)(?![\p{L}\p{N}_.]))?\s*(.*?)\s*$/u.exec(text);
      need(found && deviation.length < 2, `${given.slice(0, 60)} is not understood`);
      const number = decimal(found[1]).over(new Fraction(BigInt(found[2] || 1)));
      if (!found[3]) return quantityOf(number);
      const plain = found[3].replace(/[·×⋅]/g, "*").replace(/²/g, "^2").replace(/³/g, "^3");
      const x = evaluated(parsed(plain.replace(/(?<=[\p{L}\p{N}_)°%])\s+(?=[\p{L}_(°%])/gu, "*")), unit, units);
      need(!kind || isOf(catalogue.dimensions[kind], x), `${given.slice(0, 60)} has the wrong dimension`);
      return { ...x, value: x.value.times(number) };
    }

    /** The row of the catalogue for these parameters; lists among them are taken apart. */
    function row(model, given) {
      if (model === "prony") {
        const [k, b] = ["k", "b"].map((name) => given.get(name));
        need(Array.isArray(k) && Array.isArray(b) && k.length === b.length && k.length > 0 && k.length <= 20, "k and b must be lists alike");
        [["k", k], ["b", b]].forEach(([name, list]) => given.delete(name) && list.forEach((x, i) => given.set(`${name}_${i + 1}`, x)));
        const one = (i) => ` + k_${i}*b_${i}*s/(k_${i} + b_${i}*s)`;
        return [["k0", ...k.map((_, i) => `k_${i + 1} b_${i + 1}`)].join(" "), `k0${k.map((_, i) => one(i + 1)).join("")}`];
      }
      if (model === "pade-delay") {
        const order = given.get("order");
        need(order && order.whole && order.whole.n >= 1n && order.whole.n <= 10n, "the order must be a whole number from 1 to 10");
        given.delete("order");
        const n = Number(order.whole.n);
        const weight = (i) => (factorial(n) / factorial(i) / factorial(n - i)) * factorial(2 * n - i);
        const p = (x) => Array.from({ length: n + 1 }, (_, i) => `${weight(i)}*(${x}s*tau)^${i}`).join(" + ");
        return ["tau", p("-"), "0", "0", p("")];
      }
      const full = given.has("Z") ? `${model} Z` : model;
      need(own(catalogue.models, full), `the model ${model.slice(0, 40)} is not understood`);
      return catalogue.models[full];
    }

    /** Formulas of an environment (one) or effect (four), and the numbers of their names; `felt`: what may be referred to. */
    function element(table, count, felt) {
      need(table instanceof Map && typeof table.get("model") === "string", "an environment or effect has no model");
      const model = table.get("model");
      const given = new Map([...table].filter(([key]) => !["model", "name", "parameters"].includes(key)));
      const free = table.get("parameters") || new Map();
      const [signature, ...texts] = row(model, given);
      const names = new Map(signature.split(" ").map((x) => [x.replace(/[=?@].*$/, ""), x]));
      const complete = [...names].every(([key, x]) => x.includes("?") || given.has(key));
      const formulas = signature.includes("=");
      const fits = texts.length === count && complete && [...given.keys()].every((key) => names.has(key)) && free instanceof Map;
      need(fits && (formulas || !free.size), `the parameters of ${model} are not understood`);
      const referred = (x, kind) => {
        if (typeof x !== "string" || !felt || !x.trim().startsWith("environment.")) return quantity(x, kind);
        const name = x.trim().slice("environment.".length).replace(/\[([0-9]+)\]$/, "_$1");
        need(felt.numbers.has(name), `${x.slice(0, 60)} is no parameter of the environment`);
        return felt.numbers.get(name);
      };
      const written = (x) => (typeof x === "string" ? x : x.whole ? `${x.whole.n}` : x instanceof Fraction ? `${x.n}${x.d === 1n ? "" : `/${x.d}`}` : "?");
      const formulasOf = texts.map((text) => (formulas ? text.replace(/\b[A-Z]\b/, (x) => written(given.get(x))) : text));
      const kindOf = (key) => (own(catalogue.dimensions, key) ? key : key[0].toLowerCase());
      const values = formulas ? [...free].map(([key, x]) => [key, referred(x, "")]) : [...names.keys()].map((key) => [key, referred(given.has(key) ? given.get(key) : ZERO, kindOf(key))]);
      const lags = formulas ? [] : [...names.keys()].filter((key) => names.get(key).includes("@"));
      return { trees: formulasOf.map(parsed), numbers: new Map(values), lags, length: formulasOf.reduce((n, text) => n + [...text].length, 0) };
    }

    /** The formulas' values; u/v is exp(-s lag) of delays, which must be 0. */
    function evaluatedElement(x, { s, pi }) {
      need(x.lags.every((key) => !x.numbers.get(key).value.n), "there is a delay, and this is for rational scenes");
      const known = new Map([...x.numbers].map(([name, number]) => [name, at(number, pi)]));
      known.set("s", s).set("j", [value(0n, 1n), UNIT]).set("pi", [value(pi, 0n, [0, 1]), UNIT]);
      if (x.lags.length) known.set("u", [UNIT, UNIT]).set("v", [UNIT, UNIT]);
      const leaf = (word) => {
        if (known.has(word)) return known.get(word);
        need(/^[.0-9]/.test(word), `the name ${word.slice(0, 40)} is not known`);
        return at(quantityOf(decimal(word)), pi);
      };
      return x.trees.map((tree) => evaluated(tree, leaf, combined));
    }

    /** Put FREE for a number of a file. */
    function leaveFree(table, path) {
      const inside = (place, key) => {
        const there = place instanceof Map ? typeof key === "string" && place.has(key) : Array.isArray(place) && Number.isInteger(key) && key >= 0 && key < place.length;
        need(there, "the scene has no such number");
        return place instanceof Map ? place.get(key) : place[key];
      };
      const last = path[path.length - 1];
      const place = path.slice(0, -1).reduce(inside, table);
      quantity(inside(place, last), "");
      if (place instanceof Map) place.set(last, FREE);
      else place[last] = FREE;
    }

    /** Environment and what is rendered, of a file; `name`: which of several. */
    function chosen(table, name) {
      if (!table.has("environments") && name === null) return [table.get("environment"), table.get("rendered")];
      const found = tables(table.get("environments")).filter((x) => (x.has("name") ? x.get("name") : x.get("model")) === name);
      need(name !== null && found.length === 1 && !table.has("environment") && !table.has("rendered"), "there is not one environment of that name");
      return [new Map([...found[0]].filter(([key]) => key !== "rendered")), found[0].get("rendered")];
    }

    /** What a file's device puts at the hand: a shunt of its mass and damping, and its friction at an amplitude. */
    function carried(table) {
      const keys = ["like", "m", "b", "friction", "amplitude"];
      need(table instanceof Map && [...table.keys()].every((key) => keys.includes(key)), "[device] is not understood");
      const known = Object.entries(catalogue.devices).find(([name]) => name === table.get("like"));
      need(known !== undefined, "the device is not known");
      const own = new Map([...Object.entries(known[1]), ...table]);
      const shunt = [...own].filter(([key]) => key === "m" || key === "b");
      need(shunt.length && (own.has("friction") || !own.has("amplitude")), "a number of the device is missing");
      const rubbing = [["model", "coulomb-friction"], ["force", own.get("friction")], ["amplitude", own.get("amplitude")]];
      return [new Map([["model", "shunt"], ...shunt]), ...(own.has("amplitude") ? [new Map(rubbing)] : [])];
    }

    /** Band, thresholds and chain of a scene file; `name`: which of several environments; `free`: keys of a number left free. */
    return function scene(text, name, free = null) {
      const table = toml(text);
      const keys = ["title", "source", "environment", "environments", "rendered", "effects", "device", "evaluation", "hand", "hands"];
      need([...table.keys()].every((key) => keys.includes(key)), "the scene has keys that are not understood");
      const [felt, rendered] = chosen(table, name);
      if (free) leaveFree(table.has("environments") ? new Map([...table, ["environment", felt], ["rendered", rendered]]) : table, free);
      const environment = element(felt, 1);
      const source = rendered === undefined ? environment : element(rendered, 1, environment);
      const worn = table.has("device") ? carried(table.get("device")) : [];
      const effects = [...tables(table.get("effects") || []), ...worn].map((x) => element(x, 4));
      const every = [environment, source, ...effects];
      const told = table.get("evaluation") || new Map();
      const hands = tables(table.has("hand") ? [table.get("hand")] : table.get("hands") || []);
      need(told instanceof Map && [...told.keys()].every((key) => key === "band" || key === "jnd"), "[evaluation] is not understood");
      const band = told.has("band") ? told.get("band") : [ZERO, new Fraction(15n)];
      need(Array.isArray(band) && band.length === 2, "the band is not a pair");
      const jnd = told.has("jnd") ? told.get("jnd") : new Fraction(1n, 10n);
      const both = jnd instanceof Map ? jnd : new Map(PARTS.map((part) => [part, jnd]));
      need(both.size === 2 && PARTS.every((part) => both.has(part)), "the threshold is not a number, nor one for each part");
      const threshold = PARTS.map((part) => quantity(both.get(part), "z"));
      if (free) {
        const numbers = [...threshold, ...every.flatMap((x) => [...x.numbers.values()])];
        const named = (tree) => (typeof tree === "string" ? tree === "pi" : Array.isArray(tree) && tree.slice(1).some(named));
        const alone = numbers.every((x) => x === FREE || x.pi === 0) && !every.some((x) => x.trees.some(named));
        need(alone && numbers.includes(FREE), "a parameter is free beside pi");
      }
      return {
        band: band.map((x) => quantity(x, "o")),
        threshold,
        elements: { environment, rendered: source, effects },
        length: every.reduce((n, x) => n + x.length, 0),
        /** The dynamics of a hand: one of the file by its name, or of mass, damping and stiffness. */
        hand(which, numbers) {
          const named = hands.filter((x) => (x.has("name") ? x.get("name") : "hand") === which);
          need(numbers || (named.length === 1 && !named[0].has("model")), "the scene has not one hand of that name");
          const given = numbers ? numbers.map((x, i) => ["mbk"[i], x]) : [...named[0]].filter(([key]) => key !== "source");
          const own = element(new Map([["model", "mass-spring-damper"], ...given]), 1);
          return (where) => evaluatedElement(own, where)[0];
        },
        /** H_env and H_perc, each numerator and denominator. */
        at(where) {
          let [[top, bottom]] = evaluatedElement(source, where);
          effects.map((effect) => evaluatedElement(effect, where)).forEach(([[a, x], [b, y], [c, z], [d, w]]) => {
            const above = plus(times(times(a, y), top), times(times(b, x), bottom));
            const below = plus(times(times(c, w), top), times(times(d, z), bottom));
            [top, bottom] = [times(above, times(z, w)), times(below, times(x, y))];
          });
          return [evaluatedElement(environment, where)[0], [top, bottom]];
        },
      };
    };
  }

  return {
    Refused, need, signOf, sum, bitsOf, wordsOf, MOST_WORDS, divisor, Fraction, ZERO, ONE, decimal, toml,
    UNIT, value, plus, times, conjugate, combined, PARTS, quantityOf, at, own, reader,
  };
})();
if (typeof module !== "undefined") module.exports = haptisymScene;
