// Checks a certificate against the scene file that it is about: written from docs/certificates.md, with nothing from elsewhere.
// A scene and a certificate are texts; `catalogue` lists the units and models that are understood. Nothing here is a float.
const haptisymCheck = (function () {
  "use strict";

  class Refused extends Error {}

  function need(condition, why) {
    if (!condition) throw new Refused(why);
  }

  // Exact fractions.

  const size = (n) => (n < 0n ? -n : n);

  /** Binary digits; none of 0. */
  function bitsOf(n) {
    const text = size(n).toString(16);
    return 4 * text.length - Math.clz32(parseInt(text[0], 16)) + 28;
  }

  const wordsOf = (n) => Math.ceil(bitsOf(n) / 64);
  const MOST_WORDS = 500;
  const down = (n, d) => n / d - (n % d < 0n ? 1n : 0n);
  const signOf = (n) => (n > 0n ? 1 : n < 0n ? -1 : 0);

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
    get size() { return new Fraction(size(this.n), this.d); }
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

  // SHA-256 of a text in UTF-8 (FIPS 180-4).

  function primes(count) {
    const found = [];
    for (let n = 2; found.length < count; n += 1) if (found.every((p) => n % p)) found.push(n);
    return found;
  }

  /** The first 32 bits of the fraction of a root, exactly. */
  function rootBits(p, degree) {
    const target = BigInt(p) << BigInt(32 * degree);
    let [low, high] = [0n, 1n << 40n];
    while (high - low > 1n) {
      const middle = (low + high) / 2n;
      if (middle ** BigInt(degree) <= target) low = middle;
      else high = middle;
    }
    return Number(low & 0xffffffffn);
  }

  function sha256(text) {
    const bytes = [...new TextEncoder().encode(text)];
    const length = BigInt(bytes.length * 8);
    bytes.push(0x80);
    while (bytes.length % 64 !== 56) bytes.push(0);
    for (let k = 7n; k >= 0n; k -= 1n) bytes.push(Number((length >> (8n * k)) & 255n));
    const rounds = primes(64).map((p) => rootBits(p, 3));
    const state = primes(8).map((p) => rootBits(p, 2));
    const turned = (x, n) => (x >>> n) | (x << (32 - n));
    for (let at = 0; at < bytes.length; at += 64) {
      const w = Array.from({ length: 16 }, (_, i) => bytes.slice(at + 4 * i, at + 4 * i + 4).reduce((x, b) => (x << 8) | b, 0));
      for (let i = 16; i < 64; i += 1) {
        const a = turned(w[i - 15], 7) ^ turned(w[i - 15], 18) ^ (w[i - 15] >>> 3);
        const b = turned(w[i - 2], 17) ^ turned(w[i - 2], 19) ^ (w[i - 2] >>> 10);
        w.push((w[i - 16] + a + w[i - 7] + b) | 0);
      }
      let [a, b, c, d, e, f, g, h] = state;
      for (let i = 0; i < 64; i += 1) {
        const one = (h + (turned(e, 6) ^ turned(e, 11) ^ turned(e, 25)) + ((e & f) ^ (~e & g)) + rounds[i] + w[i]) | 0;
        const two = ((turned(a, 2) ^ turned(a, 13) ^ turned(a, 22)) + ((a & b) ^ (a & c) ^ (b & c))) | 0;
        [h, g, f, e, d, c, b, a] = [g, f, e, (d + one) | 0, c, b, a, (one + two) | 0];
      }
      [a, b, c, d, e, f, g, h].forEach((x, i) => { state[i] = (state[i] + x) | 0; });
    }
    return state.map((x) => (x >>> 0).toString(16).padStart(8, "0")).join("");
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
    const blank = () => take(/(?:[ \t]|\n|#[^\n]*)*/);
    const space = () => take(/[ \t]*/);

    function string() {
      const found = take(/"(?!"")((?:[^"\\\n\u0000-\u0008\u000b-\u001f\u007f]|\\["\\btnfr]|\\u[0-9a-fA-F]{4}|\\U[0-9a-fA-F]{8})*)"/) || take(/'(?!'')([^'\n\u0000-\u0008\u000b-\u001f\u007f]*)'/);
      if (!found) return null;
      if (found[0][0] === "'") return found[1];
      return found[1].replace(/\\(?:u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|(.))/gu, (_, short, long, other) => (other ? ESCAPES[other] : String.fromCodePoint(parseInt(short || long, 16))));
    }

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
      return path;
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
      const path = key();
      if (!take(/=/)) fail();
      const target = inside(table, path.slice(0, -1));
      if (target.has(path[path.length - 1])) fail();
      space();
      target.set(path[path.length - 1], value(0));
    }

    function value(depth) {
      need(depth < 50, "the scene is nested too deeply");
      const told = string();
      if (told !== null) return told;
      if (take(/\[/)) {
        const list = [];
        closed.add(list);
        for (blank(); !take(/\]/); blank()) {
          list.push(value(depth + 1));
          blank();
          if (!take(/,/)) {
            blank();
            if (!take(/\]/)) fail();
            return list;
          }
        }
        return list;
      }
      if (take(/\{/)) {
        const table = new Map();
        space();
        if (!take(/\}/)) {
          do pair(table); while (space() && take(/,/));
          if (!take(/\}/)) fail();
        }
        closed.add(table);
        return table;
      }
      const other = take(/0(?:x[0-9a-fA-F](?:_?[0-9a-fA-F])*|o[0-7](?:_?[0-7])*|b[01](?:_?[01])*)(?![\w.:-])/);
      if (other) return { whole: new Fraction(BigInt(other[0].replace(/_/g, ""))) };
      const number = take(/[+-]?(?:0|[1-9](?:_?[0-9])*)(\.[0-9](?:_?[0-9])*)?([eE][+-]?[0-9]{1,3})?(?![\w.:-])/);
      if (!number) fail();
      const found = decimal(number[0].replace(/_/g, ""));
      return number[1] || number[2] ? found : { whole: found };
    }

    let here = root;
    for (blank(); at < text.length; blank()) {
      if (take(/\[\[/)) {
        const path = key();
        const table = inside(root, path.slice(0, -1));
        const last = path[path.length - 1];
        if (!table.has(last)) table.set(last, []);
        if (!Array.isArray(table.get(last)) || closed.has(table.get(last))) fail();
        here = new Map();
        table.get(last).push(here);
        if (!take(/\]\]/)) fail();
      } else if (take(/\[/)) {
        const path = key();
        const above = inside(root, path.slice(0, -1));
        if (above.has(path[path.length - 1])) fail();
        here = inside(above, path.slice(-1));
        if (!take(/\]/)) fail();
      } else pair(here);
      if (!take(/[ \t]*(?:#[^\n]*)?(?:\n|$)/)) fail();
    }
    return root;
  }

  // Values: Gaussian integers, each that of a polynomial, with bounds on its degrees: in s or omega, in pi, in tan(omega tau/2) of delays, in Re and Im
  // of (j omega)^alpha of orders alpha together.

  const MOST_OTHERS = 4;
  const degree = (place, n) => Array.from({ length: MOST_OTHERS + 2 }, (_, i) => (i === place ? n : 0));
  const CONSTANT = degree(0, 0);

  const value = (re, im = 0n, own = CONSTANT) => ({ re, im, degrees: own });
  const plus = (x, y, sign = 1n) => value(x.re + sign * y.re, x.im + sign * y.im, x.degrees.map((n, i) => Math.max(n, y.degrees[i])));
  const times = (x, y) => value(x.re * y.re - x.im * y.im, x.re * y.im + x.im * y.re, x.degrees.map((n, i) => n + y.degrees[i]));
  const conjugate = (x) => ({ ...x, im: -x.im });
  const UNIT = value(1n);
  const NOTHING = value(0n, 0n, CONSTANT.map(() => -1e6));
  const multiple = (x, n) => Array.from({ length: n }).reduce((y) => times(y, x), UNIT);

  /**
   * Where a chain is computed: s, a ratio, and whole numbers in place of pi and of what depends on omega otherwise: `others` has the
   * tangents of delays, then Re and Im of the powers of orders.
   */
  const point = (s, pi, delays = [], orders = [], others = []) => ({ s, pi, delays, orders, others });
  const onAxis = (x, pi, delays, orders, others) => point([value(0n, x, degree(0, 1)), UNIT], pi, delays, orders, others);

  /** s to a power: a whole one, times that of an order. */
  function raised(where, exponent) {
    const n = down(exponent.n, exponent.d);
    const order = exponent.minus(new Fraction(n));
    const i = where.orders.findIndex((x) => x.compare(order) === 0);
    need(size(n) < 100n && (!order.n || i >= 0), "a power of s: the proof has no such order");
    const [top, bottom] = (n < 0n ? [...where.s].reverse() : where.s).map((x) => multiple(x, Number(size(n))));
    if (!order.n) return [top, bottom];
    const place = where.delays.length + i;
    return [times(top, value(...where.others[place], degree(2 + place, 1))), bottom];
  }

  /** (1 - j t)^n, where exp(-s lag) = ((1 - j t)/(1 + j t))^n. */
  function delayed(where, lag) {
    if (!lag.n) return UNIT;
    const i = where.delays.findIndex((tau) => lag.over(tau).d === 1n);
    need(i >= 0 && lag.over(where.delays[i]).n <= 64n, "a delay: the proof has none that it is a multiple of");
    return multiple(value(1n, -where.others[i], degree(2 + i, 1)), Number(lag.over(where.delays[i]).n));
  }

  /** x + y, x - y, x * y or x / y of pairs of numerator and denominator. */
  function combined(sign, x, y) {
    const all = [...x, ...y];
    need(all.reduce((n, v) => n + wordsOf(v.re) + wordsOf(v.im), 0) < MOST_WORDS, "a number is too large");
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
    const sum = () => chain(() => chain(signed, "*", "/"), "+", "-");
    function signed() {
      const s = sign("+", "-");
      if (s) return [s, "0", signed()];
      return power();
    }
    function power() {
      let tree;
      const isInner = sign("(");
      if (isInner) {
        tree = sum();
        need(sign(")"), why);
      } else {
        need(at < tokens.length && !tokens[at][3], why);
        tree = tokens[at++][0];
      }
      if (!sign("^", "**")) return tree;
      const bracket = sign("(");
      const minus = sign("+", "-") === "-";
      need(at < tokens.length && /^([0-9]{1,2}(\.[0-9]{0,12})?|\.[0-9]{1,12})$/.test(tokens[at][0]), why);
      let size = decimal(tokens[at++][0]);
      if (bracket && sign("/")) {
        need(at < tokens.length && /^[1-9][0-9]?$/.test(tokens[at][0]) && /^[0-9]{1,2}$/.test(tokens[at - 2][0]), why);
        size = size.over(decimal(tokens[at++][0]));
      }
      need((!bracket || sign(")")) && !sign("^", "**"), why);
      const n = minus ? ZERO.minus(size) : size;
      if (n.d === 1n) return ["^", tree, Number(n.n)];
      need(!isInner && !/^[.0-9]/.test(tree), why);
      return `${tree}^${n.n}/${n.d}`; // a name with its broken power
    }
    const tree = sum();
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

  // Quantities: value * pi^pi, and powers of kg, m and s in trillionths, as broken ones have twelve decimals (null without a unit).

  const TRILLION = 10n ** 12n;

  const quantityOf = (x, pi = 0, dimension = null) => ({ value: x, pi, dimension });

  /** A parameter that is left free takes the place of pi. */
  const FREE = Object.freeze(quantityOf(ONE, 1));

  function at(x, pi) {
    const [up, down] = [Math.max(x.pi, 0), Math.max(-x.pi, 0)];
    const top = x.value.n ? value(x.value.n * pi ** BigInt(up), 0n, degree(1, up)) : NOTHING;
    return [top, value(x.value.d * pi ** BigInt(down), 0n, degree(1, down))];
  }

  /** A number of a JND at a frequency, numerator and denominator. */
  function limitAt(x, { s: [{ im: omega }], pi }) {
    if (x.value) return at(x, pi);
    return evaluated(x, (word) => (word === "omega" ? [value(omega, 0n, degree(0, 1)), UNIT] : at(quantityOf(decimal(word)), pi)), combined);
  }

  function reader(catalogue) {
    const own = (table, name) => Object.prototype.hasOwnProperty.call(table, name);

    function unit(word) {
      const [name, power] = word.split("^");
      const whole = own(catalogue.units, name);
      const [prefix, base] = whole ? ["", name] : [name.slice(0, 1), name.slice(1)];
      need(own(catalogue.units, base) && (!prefix || (own(catalogue.prefixes, prefix) && catalogue.units[base][3])), `the unit ${name.slice(0, 40)} is not understood`);
      const [factor, pi, dimension] = catalogue.units[base];
      const [n, d] = factor.split("/");
      const scale = new Fraction(10n).power(prefix ? catalogue.prefixes[prefix] : 0);
      const x = new Fraction(BigInt(n), BigInt(d || 1)).times(scale);
      const [up, below] = (power || "1").split("/").map(BigInt);
      need(power === undefined || (x.n === 1n && x.d === 1n && pi === 0), `the power ${word.slice(0, 40)} is not rational`);
      return quantityOf(x, pi, dimension.map((k) => (BigInt(k) * TRILLION * up) / (below || 1n)));
    }

    function units(sign, x, y) {
      need(sign === "*" || sign === "/", "a unit is a product of powers");
      const n = sign === "*" ? 1 : -1;
      return quantityOf(x.value.times(y.value.power(n)), x.pi + n * y.pi, x.dimension.map((k, i) => k + BigInt(n) * y.dimension[i]));
    }

    /** Whether a quantity is of a kind; of an empty list any may be. */
    const isOf = (kind, { dimension }) => !kind.length || kind.some((d) => d.every((k, i) => BigInt(k) * TRILLION === dimension[i]));

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
        given.delete("k");
        given.delete("b");
        [["k", k], ["b", b]].forEach(([name, list]) => list.forEach((x, i) => given.set(`${name}_${i + 1}`, x)));
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
      if (model === "sampled-loop") {
        const [method, samples] = [given.get("method"), given.has("delay") ? given.get("delay") : { whole: ZERO }];
        need(samples && samples.whole && samples.whole.n >= 0n && samples.whole.n <= 20n, "the delay must be a whole number of samples, from 0 to 20");
        need(typeof method === "string" && own(catalogue.clocks, method), "the method of a clock is not understood");
        ["method", "delay"].forEach((key) => given.delete(key));
        const n = Number(samples.whole.n);
        return ["T@1", `u^${n}*(v - u)`, "0", "0", `s*T*v^${n + 1}`, catalogue.clocks[method]];
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
      const names = new Map(signature.split(" ").map((x) => [x.replace(/[=?@^].*$/, ""), x]));
      const complete = [...names].every(([key, x]) => x.includes("?") || given.has(key));
      const fits = Math.min(texts.length, 4) === count && complete && [...given.keys()].every((key) => names.has(key)) && free instanceof Map;
      const formulas = signature.includes("=");
      need(fits && (formulas || !free.size), `the parameters of ${model} are not understood`);
      const referred = (x, kind) => {
        if (typeof x !== "string" || !felt || !x.trim().startsWith("environment.")) return quantity(x, kind);
        const name = x.trim().slice("environment.".length).replace(/\[([0-9]+)\]$/, "_$1");
        need(felt.numbers.has(name), `${x.slice(0, 60)} is no parameter of the environment`);
        return felt.numbers.get(name);
      };
      const written = (x) => (typeof x === "string" ? x : x.whole ? `${x.whole.n}` : x instanceof Fraction ? `${x.n}${x.d === 1n ? "" : `/${x.d}`}` : "?");
      const formulasOf = texts.map((text) => (formulas ? text.replace(/\b[A-Z]\b/, (x) => written(given.get(x))) : text));
      const trees = formulasOf.map(parsed);
      const values = formulas ? [...free].map(([key, x]) => [key, referred(x, "")]) : [...names.keys()].map((key) => [key, referred(given.has(key) ? given.get(key) : ZERO, own(catalogue.dimensions, key) ? key : key[0].toLowerCase())]);
      const numbers = new Map(values);
      const lags = formulas ? [] : [...names].filter(([, x]) => x.includes("@")).map(([key, x]) => [key, new Fraction(BigInt(x.split("@")[1]))]);
      const order = [...names.keys()].find((key) => names.get(key).includes("^"));
      return { trees, numbers, lags, order, length: formulasOf.reduce((n, text) => n + [...text].length, 0) };
    }

    /** The formulas' values; u/v is exp(-s lag), z is s^alpha. */
    function evaluatedElement(x, where) {
      const { pi } = where;
      const known = new Map([...x.numbers].map(([name, number]) => [name, at(number, pi)]));
      known.set("s", where.s).set("j", [value(0n, 1n), UNIT]).set("pi", [value(pi, 0n, degree(1, 1)), UNIT]);
      x.lags.forEach(([key, n]) => {
        const lag = x.numbers.get(key);
        need(lag.pi === 0 && lag.value.n >= 0n, "a delay is negative, or has pi in it");
        const u = delayed(where, lag.value.times(n));
        known.set("u", [u, UNIT]).set("v", [conjugate(u), UNIT]);
      });
      if (x.order) {
        const order = x.numbers.get(x.order);
        need(order.pi === 0 && order.value.n > 0n && order.value.compare(ONE) < 0, "an order is not a number between 0 and 1");
        known.set("z", raised(where, order.value));
      }
      // A pair of a ratio and an exponent of s beside it: in a product they are added, as s^a s^b = s^(a + b).
      const leaf = (word) => {
        const [name, power] = word.split("^");
        if (name === "s" && power) return [[UNIT, UNIT], new Fraction(...power.split("/").map(BigInt))];
        if (known.has(word)) return [known.get(word), ZERO];
        need(/^[.0-9]/.test(word), `the name ${word.slice(0, 40)} is not known`);
        return [at(quantityOf(decimal(word)), pi), ZERO];
      };
      const shifted = (y, n) => (n.n ? combined("*", y, raised(where, n)) : y);
      const isNothing = ([top]) => top.degrees[0] < 0; // the polynomial 0, whose degree is below all others
      const both = (sign, [a, m], [b, n]) => {
        if (sign === "*" || sign === "/") return [combined(sign, a, b), sign === "*" ? m.plus(n) : m.minus(n)];
        const alike = m.compare(n) === 0 && [...a, ...b].every((v) => Math.max(...v.degrees) <= 0); // multiples of one power, without s
        if (alike || isNothing(a) || isNothing(b)) return [combined(sign, a, b), isNothing(a) ? n : m];
        return [combined(sign, shifted(a, m), shifted(b, n)), ZERO];
      };
      return x.trees.map((tree) => shifted(...evaluated(tree, leaf, both)));
    }

    const isFormula = (x) => typeof x === "string" && /(?<![\p{L}\p{N}_])omega(?![\p{L}\p{N}_])/u.test(x);

    /** A number of a JND: a quantity, or the tree of a rational formula in omega. */
    const limit = (given, kind) => (isFormula(given) ? parsed(given) : quantity(given, kind));

    const KEYS = { square: ["real", "imag", "floor"], ellipse: ["real", "imag", "tilt"], diamond: ["real", "imag"], polygon: ["corners"] };

    /** The JND: its shape, its numbers by name, and the corners of a polygon in their order counterclockwise. */
    function regionOf(jnd) {
      const told = jnd instanceof Map ? jnd : new Map([["real", jnd], ["imag", jnd]]);
      const shape = told.has("shape") ? told.get("shape") : "square";
      const known = own(KEYS, shape) ? KEYS[shape] : [];
      const given = new Map([...told].filter(([key]) => key !== "shape" && key !== "proportion"));
      const fits = known.length && [...given.keys()].every((key) => known.includes(key)) && known.every((key) => given.has(key) || key === "floor" || key === "tilt");
      need(fits, "the threshold is not understood");
      if (shape === "polygon") {
        const corners = given.get("corners");
        need(Array.isArray(corners) && corners.length >= 3 && corners.length <= 24 && corners.every((x) => Array.isArray(x) && x.length === 2), "the corners are not 3 to 24 pairs");
        return { shape, limits: new Map(), corners: turned(corners.map((pair) => pair.map((x) => limit(x, "z")))) };
      }
      const limits = new Map();
      [...given].forEach(([key, x]) => {
        if (x instanceof Map) {
          need(shape === "square" && key !== "floor" && x.size === 2 && x.has("higher") && x.has("lower"), "the limits of a part are not understood");
          limits.set(key, limit(x.get("higher"), "z")).set(`${key}.lower`, limit(x.get("lower"), "z"));
        } else limits.set(key, limit(x, key === "floor" ? "k" : "z"));
      });
      if (shape === "ellipse" && !limits.has("tilt")) limits.set("tilt", quantityOf(ZERO));
      return { shape, limits, corners: [] };
    }

    /** Corners counterclockwise at omega = 1. */
    function turned(corners) {
      const at1 = corners.map((pair) => pair.map((x) => limitAt(x, onAxis(1n, 3n))));
      const area = at1.reduce((found, p, i) => {
        const q = at1[(i + 1) % at1.length];
        return combined("+", found, combined("-", combined("*", p[0], q[1]), combined("*", p[1], q[0])));
      }, [NOTHING, UNIT]);
      return signOf(area[0].re) * signOf(area[1].re) < 0 ? [...corners].reverse() : corners;
    }

    /** A list of tables, of a file. */
    function tables(x) {
      need(Array.isArray(x) && x.length <= 100 && x.every((y) => y instanceof Map), "a list of at most 100 tables is none");
      return x;
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

    /** Band, thresholds and chain of a scene file; `name`: which of several environments; `free`: keys of a number left free. */
    return function scene(text, name, free = null) {
      const table = toml(text);
      const keys = ["title", "source", "environment", "environments", "rendered", "effects", "evaluation", "hand", "hands"];
      need([...table.keys()].every((key) => keys.includes(key)), "the scene has keys that are not understood");
      let [felt, rendered] = [table.get("environment"), table.get("rendered")];
      if (table.has("environments") || name !== null) {
        const listed = tables(table.get("environments")).filter((x) => (x.has("name") ? x.get("name") : x.get("model")) === name);
        need(name !== null && listed.length === 1 && !table.has("environment") && !table.has("rendered"), "there is not one environment of that name");
        felt = new Map([...listed[0]].filter(([key]) => key !== "rendered"));
        rendered = listed[0].get("rendered");
      }
      if (free) {
        if (!table.has("environments")) leaveFree(table, free);
        else leaveFree(new Map([...table, ["environment", felt], ["rendered", rendered]]), free);
      }
      const own = element(felt, 1);
      const source = rendered === undefined ? own : element(rendered, 1, own);
      const told = table.get("evaluation") || new Map();
      const between = tables(table.get("effects") || []).map((x) => element(x, 4));
      const hands = tables(table.has("hand") ? [table.get("hand")] : table.get("hands") || []);
      need(told instanceof Map && [...told.keys()].every((key) => key === "band" || key === "jnd"), "[evaluation] is not understood");
      const band = told.has("band") ? told.get("band") : [ZERO, new Fraction(15n)];
      need(Array.isArray(band) && band.length === 2, "the band is not a pair");
      const region = regionOf(told.has("jnd") ? told.get("jnd") : new Fraction(1n, 10n));
      if (free) {
        const elements = [own, source, ...between];
        need(region.shape === "square" && region.limits.size === 2, "a parameter is free in a scene with a region of its own");
        const numbers = [...region.limits.values(), ...elements.flatMap((x) => [...x.numbers.values()])];
        const named = (tree) => (typeof tree === "string" ? tree === "pi" : Array.isArray(tree) && tree.slice(1).some(named));
        const alone = numbers.every((x) => x === FREE || x.pi === 0) && !elements.some((x) => x.trees.some(named));
        need(alone && numbers.includes(FREE), "a parameter is free beside pi");
      }
      return {
        band: band.map((x) => quantity(x, "o")),
        region,
        elements: { environment: own, rendered: source, effects: between },
        length: [own, source, ...between].reduce((n, x) => n + x.length, 0),
        /** The dynamics of a hand: one of the file by its name, or of mass, damping and stiffness. */
        hand(which, numbers) {
          const every = hands.filter((x) => (x.has("name") ? x.get("name") : "hand") === which);
          need(numbers || (every.length === 1 && !every[0].has("model")), "the scene has not one hand of that name");
          const given = numbers ? numbers.map((x, i) => ["mbk"[i], x]) : [...every[0]].filter(([key]) => key !== "source");
          const own = element(new Map([["model", "mass-spring-damper"], ...given]), 1);
          return (where) => evaluatedElement(own, where)[0];
        },
        /** H_env and H_perc, each numerator and denominator; what is rendered with a clock, at the s of its method. */
        at(where) {
          const effects = between.map((effect) => evaluatedElement(effect, where));
          const clocks = effects.flatMap((x) => x.slice(4));
          need(!clocks.length || (clocks.length === 1 && effects[0].length > 4), "a clock that is not the first effect");
          const [env] = evaluatedElement(own, where);
          let [[top, bottom]] = evaluatedElement(source, clocks.length ? { ...where, s: clocks[0], orders: [] } : where);
          effects.forEach(([[a, x], [b, y], [c, z], [d, w]]) => {
            const above = plus(times(times(a, y), top), times(times(b, x), bottom));
            const below = plus(times(times(c, w), top), times(times(d, z), bottom));
            [top, bottom] = [times(above, times(z, w)), times(below, times(x, y))];
          });
          return [env, [top, bottom]];
        },
      };
    };
  }

  // Reading a certificate: nothing but what the specification knows.

  function keyed(x, ...keys) {
    const own = x && typeof x === "object" && !Array.isArray(x) ? Object.keys(x) : null;
    need(own && own.length === keys.length && keys.every((key) => own.includes(key)), `expected an object with the keys ${keys.join(", ")}`);
    return keys.map((key) => x[key]);
  }

  function listed(x, most, least = 0) {
    need(Array.isArray(x) && x.length >= least && x.length <= most, `expected a list of ${least} to ${most} entries`);
    return x;
  }

  function whole(x, low, high) {
    need(Number.isInteger(x) && x >= low && x <= high, `expected a whole number from ${low} to ${high}`);
    return x;
  }

  function number(x) {
    const found = typeof x === "string" && /^(-?[0-9]{1,2000})(?:\/([1-9][0-9]{0,1999})|((?:\.[0-9]{1,2000})?(?:E[+-]?[0-9]{1,3})?))$/.exec(x);
    need(found, `${String(x).slice(0, 40)} is not a number`);
    return found[2] ? new Fraction(BigInt(found[1]), BigInt(found[2])) : decimal(x);
  }

  /** A list of numbers that ascends. */
  function ascending(x, most, least = 0) {
    const found = listed(x, most, least).map(number);
    need(found.every((y, i) => !i || found[i - 1].compare(y) < 0), "numbers do not ascend");
    return found;
  }

  function polynomial(x) {
    const rows = listed(x, 300, 1).map((row) => listed(row, 100, 1));
    rows.flat().forEach((n) => need(typeof n === "string" && /^-?[0-9]{1,2000}$/.test(n), "a polynomial is not one"));
    const found = rows.map((row) => row.map(BigInt));
    need(found[found.length - 1].some((n) => n), "a leading coefficient is 0");
    return found;
  }

  /** JSON in which no key stands twice, and all numbers are small and whole: written again it is the same. */
  function json(text) {
    need(new TextEncoder().encode(text).length <= 4e6, "the certificate is too large");
    let found;
    try {
      found = JSON.parse(text);
      const plain = text.replace(/"(?:[^"\\]|\\.)*"|-0(?![.eE])|\s+/g, (told) => (told === "-0" ? "0" : told[0] === '"' ? JSON.stringify(JSON.parse(told)) : ""));
      need(JSON.stringify(found) === plain, "a key stands twice in the certificate, or a number is not whole");
    } catch (error) {
      throw new Refused(error instanceof Refused ? error.message : "the certificate is no JSON");
    }
    return found;
  }

  // Rule 1: the functions of the scene are those of the proof.

  const PARTS = ["real", "imag"];
  const CURVES = ["environment", "perceived", "excess", "difference", "sum"];

  function product(x, factors) {
    const [told, rows] = keyed(x, "number", "powers");
    const own = number(told);
    const pairs = listed(rows, 500).map((row) => listed(row, 2, 2));
    const powers = new Map(pairs.map(([i, n]) => [whole(i, 0, factors.length - 1), whole(n, -100, 100)]));
    need(powers.size === pairs.length, "a factor stands twice in a product");
    need(own.n || !pairs.length, "a function that is zero everywhere has no factors");
    const turns = (factors.length ? factors[0].waves : []).map((_, k) => [...powers].reduce((sum, [i, n]) => sum + n * factors[i].waves[k], 0));
    need(turns.every((n) => n % 2 === 0), "a product changes its sign in a turn");
    const words = [...powers].reduce((sum, [i, n]) => sum + Math.abs(n) * factors[i].words, 0);
    return { number: own, powers, words, circles: turns.map((n) => -n / 2) }; // cos^2 = 1/(1 + t^2)
  }

  /** What is raised to which power, with values (or degrees) of the factors and of 1 + t^2 for each tangent t. */
  const each = (p, factors, circles) => [...[...p.powers].map(([i, n]) => [factors[i], n]), ...circles.map((c, i) => [c, p.circles[i] || 0])];

  /** Numerator and denominator. */
  function sides(p, factors, circles) {
    const found = [p.number.n, p.number.d];
    each(p, factors, circles).forEach(([y, n]) => {
      const i = n < 0 ? 1 : 0;
      need(wordsOf(y) * Math.abs(n) + wordsOf(found[i]) < MOST_WORDS, "a number is too large");
      found[i] *= y ** BigInt(Math.abs(n));
    });
    return found;
  }

  /** Their degrees in the variable of that place. */
  function degrees(p, place, factors, count) {
    const found = [0, 0];
    const circles = Array.from({ length: count }, (_, i) => (place === 2 + i ? 2 : 0));
    each(p, factors.map((x) => x.degrees[place]), circles).forEach(([y, n]) => { found[n < 0 ? 1 : 0] += y * Math.abs(n); });
    return found;
  }

  function functions(scene, where) {
    const [[n, d], [p, q]] = scene.at(where);
    const [pd, qn, dq] = [times(p, d), times(q, n), times(d, q)];
    const pairs = { environment: [n, d], perceived: [p, q], difference: [plus(pd, qn, -1n), dq], sum: [plus(pd, qn), dq] };
    const found = {};
    Object.entries(pairs).forEach(([name, [u, v]]) => {
      const turned = times(u, conjugate(v)); // u/v = u conj(v)/|v|^2
      const below = times(v, conjugate(v));
      found[`${name}.real`] = [{ ...turned, im: 0n }, below];
      found[`${name}.imag`] = [{ ...turned, re: turned.im, im: 0n }, below];
    });
    const root = times(times(n, d), times(q, q)); // X^2/|H|^2 = (Re ((P D - Q N) conj(D Q)))^2/(|N|^2 |D|^2 |Q|^4)
    Object.entries(judged(scene.region, found, times(root, conjugate(root)), where)).forEach(([name, terms]) => {
      const alone = terms.length === 1 && terms[0].length === 1;
      terms.forEach((term, i) => term.forEach((f, j) => { found[alone ? name : `${name}.${i}.${j}`] = f; }));
    });
    return found;
  }

  /** Whether a JND is a number for each part. */
  const isSquare = ({ shape, limits }) => shape === "square" && limits.size === 2 && [...limits.values()].every((x) => x.value);

  // JND regions: lists of terms, each a list of functions; outside where all functions of one term are positive.

  const squared = (x) => combined("*", x, x);
  const negative = ([top, bottom]) => [plus(NOTHING, top, -1n), bottom];
  const above = (x, limit) => combined("-", x, limit);
  const ONCE = [UNIT, UNIT];

  /** What must not be positive at a frequency, of a JND; `size`: of the square of |H|, but for what stands below dH. */
  function judged(region, found, size, where) {
    const limit = (x) => limitAt(x, where);
    const over = (x) => [x[0], times(x[1], size)];
    const [x, y] = PARTS.map((part) => [found[`difference.${part}`][0], UNIT]);
    const change = PARTS.map((part) => found[`difference.${part}`]);
    if (region.shape === "square") return Object.fromEntries(PARTS.map((part, i) => [`excess.${part}`, sided(region, part, over(squared([x, y][i])), found, limit)]));
    if (region.shape === "polygon") return cornered(region, change, [x, y], over, limit);
    const widths = PARTS.map((part) => limit(region.limits.get(part)));
    const [u, w] = [x, y].map((z, i) => combined("/", z, widths[i]));
    const nearer = above(...change.map((z, i) => squared(combined("/", z, widths[i]))));
    const tilt = region.shape === "ellipse" ? limit(region.limits.get("tilt")) : [NOTHING, UNIT];
    const rest = above(ONCE, squared(tilt));
    const outside = [u, w].map((z) => [[above(combined("/", over(squared(z)), rest), ONCE)]]);
    const both = { "outside.real": outside[0], "outside.imag": outside[1], nearer: [[nearer]] };
    if (region.shape === "diamond") return { "excess.joint": ["+", "-"].map((sign) => [above(over(squared(combined(sign, u, w))), ONCE)]), ...both };
    const twice = combined("*", combined("*", tilt, [value(2n), UNIT]), combined("*", u, w));
    const square = combined("-", combined("+", squared(u), squared(w)), twice);
    return { "excess.joint": [[above(combined("/", over(square), rest), ONCE)]], ...both };
  }

  /** One part, with a limit for each way or a floor. */
  function sided({ limits }, part, square, found, limit) {
    const c = limit(limits.get(part));
    const [lower, floor] = [`${part}.lower`, "floor"].map((key) => (limits.has(key) ? limit(limits.get(key)) : null));
    if (!lower && !floor) return [[above(square, squared(c))]];
    const [higher, less] = [c, lower || c].map((z) => above(combined("/", square, squared(z)), ONCE));
    const least = floor ? [above(combined("/", squared(found[`difference.${part}`]), squared(floor)), ONCE)] : [];
    if (!lower) return [[higher, ...least]];
    const growth = above(squared(found[`perceived.${part}`]), squared(found[`environment.${part}`]));
    return [[growth, higher, ...least], [negative(growth), less, ...least], [higher, less, ...least]];
  }

  /** The largest of the edges p x + q y - 1 of a polygon. */
  function cornered({ corners, scale }, change, [x, y], over, limit) {
    const by = (a, b) => combined("*", a, b);
    const at1 = corners.map((pair) => pair.map((z) => (scale ? by(limit(z), limit(scale)) : limit(z))));
    const edges = at1.map(([a, b], i) => {
      const [right, up] = at1[(i + 1) % at1.length];
      const area = above(by(a, up), by(b, right));
      return [combined("/", above(up, b), area), combined("/", above(a, right), area)];
    });
    const beyond = (along, plain) => [along, above(over(squared(plain)), ONCE)];
    const joint = edges.map(([p, q]) => beyond(...[change, [x, y]].map(([u, w]) => combined("+", by(p, u), by(q, w)))));
    const alone = (k) => edges.map((edge) => beyond(by(edge[k], change[k]), by(edge[k], [x, y][k])));
    const isPlain = corners.flat().every((z) => z.value && !z.pi);
    const [across, upward] = [0, 1].map((k) => edges.map((edge) => edge[k])).map((list) => (isPlain ? extremes(list) : list));
    const nearer = across.map((p) => upward.map((q) => above(by(p, change[0]), by(q, change[1]))));
    return { "excess.joint": joint, "outside.real": alone(0), "outside.imag": alone(1), nearer };
  }

  /** The least and the largest of numbers. */
  function extremes(list) {
    const sorted = [...list].sort((a, b) => new Fraction(a[0].re, a[1].re).compare(new Fraction(b[0].re, b[1].re)));
    return [sorted[0], sorted[sorted.length - 1]];
  }

  const sum = (list) => list.reduce((x, y) => x + y, 0n);

  /** All points of a grid of that size, the last coordinate the quickest; those that are `paired` are two, of that sum at most. */
  function* grid(size, paired, start = []) {
    const place = start.length;
    if (place === size.length) yield start;
    else for (let k = 0; k < size[place]; k += 1) {
      for (let m = 0; m <= (place < paired ? 0 : k); m += 1) yield* grid(size, paired, [...start, place < paired ? k : [k - m, m]]);
    }
  }

  /**
   * Refused unless the products are the functions of a scene at (x, pi, tangents and powers): on a grid that decides it. `length` is that of
   * the scene's formulas; of `share` such questions none may take longer than so much of what one may.
   */
  function link(told, factors, scene, length, delays = [], orders = [], share = 1) {
    const places = Array.from({ length: 2 + delays.length + orders.length }, (_, i) => i);
    const paired = 2 + delays.length;
    const work = [...factors, ...Object.values(told)].reduce((n, x) => n + x.words, 5 * length + 100);
    let [rows, before] = [[], ""];

    /** Numerator and denominator of each function, of the scene and as told. */
    function sidesAt(names, x, pi, others) {
      if (before !== `${x} ${pi}`) rows = factors.map((f) => f.at(x, pi));
      before = `${x} ${pi}`;
      const [circles, flat] = [others.slice(0, delays.length).map((t) => 1n + t * t), others.flat()];
      const values = rows.map((terms) => sum(terms.map(([turns, y]) => turns.reduce((z, k, i) => z * flat[i] ** BigInt(k), y))));
      const found = scene(x, pi, others);
      return new Map(names.map((name) => [name, [...found[name], ...sides(told[name], values, circles)]]));
    }

    /** The functions of which what is to be zero is zero on a grid; `degreesOf`: bounds of its degrees, of those of four sides. */
    function proven(names, degreesOf, isZero) {
      const bounds = names.map((name) => [name, degreesOf(start.get(name))]);
      const size = places.map((i) => Math.max(0, ...bounds.map(([, most]) => most[i])) + 1);
      const points = size.reduce((n, k, i) => n * (i < paired ? k : (k * (k + 1)) / 2), 1);
      need(size[0] <= 3000 && points * work * share <= 3e7, "the degrees are too high");
      const left = new Set(names);
      for (const steps of grid(size, paired)) {
        const own = bounds.filter(([name, most]) => left.has(name) && steps.every((k, i) => (i < paired ? k : k[0] + k[1]) <= most[i]));
        if (!own.length) continue;
        const [x, pi, ...others] = steps.map((k, i) => (i < paired ? BigInt(i === 1 ? k + 1 : k) : k.map(BigInt)));
        sidesAt(own.map(([name]) => name), x, pi, others).forEach((found, name) => {
          const [top, bottom, above, below] = found;
          need(above * bottom.re === below * top.re && above * bottom.im === below * top.im, `${name} is not that of the scene`);
          if (!isZero(name, found)) left.delete(name);
        });
      }
      return left;
    }

    const every = Object.keys(told);
    const first = scene(0n, 1n, [...delays.map(() => 0n), ...orders.map(() => [0n, 0n])]);
    const start = new Map(every.map((name) => [name, [...first[name].map((x) => x.degrees), ...[0, 1].map((k) => places.map((i) => degrees(told[name], i, factors, delays.length)[k]))]]));
    const fixed = new Map();
    for (let k = 17n; k < 25n && fixed.size < every.length; k += 1n) {
      sidesAt(every, k, k + 1n, [...delays.map((_, i) => k + 2n + BigInt(i)), ...orders.map((_, i) => [k + 3n + BigInt(i), k + 4n])]).forEach(([, bottom, , right], name) => {
        if ((bottom.re || bottom.im) && right) fixed.set(name, [right, bottom]);
      });
    }
    need(fixed.size === every.length, "a function is nowhere defined");
    const largest = (...lists) => places.map((i) => Math.max(...lists.map((x) => x[i])));
    const total = (x, y) => places.map((i) => x[i] + y[i]);
    const plain = proven(every, (four) => largest(...four), (name, [top, bottom, left, right]) => {
      const [u, v] = fixed.get(name);
      return [[top, left], [bottom, right]].every(([x, y]) => x.re * u === y * v.re && x.im * u === y * v.im);
    });
    const others = every.filter((name) => !plain.has(name));
    proven(others, ([top, bottom, left, right]) => largest(total(left, bottom), total(right, top)), () => true); // refused where one is not zero
  }

  // Rules 2 and 3: zeros and signs of polynomials, and the chart.

  const SCALE = 10n ** 100n;

  /** Whole numbers below and above pi 10^100: pi/4 = 4 arctan 1/5 - arctan 1/239 (Machin), by alternating series. */
  const PI = (function () {
    const arctangent = (n, terms) => {
      let total = ZERO;
      for (let k = 0; k < terms; k += 1) total = total.plus(new Fraction(k % 2 ? -1n : 1n, BigInt(2 * k + 1) * n ** BigInt(2 * k + 1)));
      return total;
    };
    const between = (n, terms) => [arctangent(n, terms), arctangent(n, terms + 1)].sort((x, y) => x.compare(y));
    const [fifth, other] = [between(5n, 75), between(239n, 22)];
    const ends = [0, 1].map((i) => fifth[i].times(new Fraction(16n)).minus(other[1 - i].times(new Fraction(4n))).times(new Fraction(SCALE)));
    return [ends[0].n / ends[0].d, ends[1].n / ends[1].d + 1n];
  })();

  /** Polynomials below and above p for arguments >= 0, times one positive number; only one without pi. */
  function bounds(p) {
    const n = Math.max(...p.map((row) => row.length)) - 1;
    const end = (k) => p.map((row) => sum(row.map((c, i) => c * PI[c < 0n ? 1 - k : k] ** BigInt(i) * SCALE ** BigInt(n - i))));
    return n ? [end(0), end(1)] : [end(0)];
  }

  function agreed(rows) {
    const signs = rows.map((row) => row.map(signOf));
    need(signs[0].every((x, i) => x === signs[signs.length - 1][i]), "a sign stays open");
    return signs[0];
  }

  const INFINITY = { n: 1n, d: 0n };

  /** p (a + b u). */
  const stretched = (p, a, b) => [...p, 0n].map((x, i) => a * x + (i ? b * p[i - 1] : 0n));

  /** The coefficients of p((a + b u)/(c + d u)) (c + d u)^n: from low = a/c at u = 0 to high = b/d at infinity. */
  function moved(p, low, high) {
    let [found, power] = [[p[p.length - 1]], [1n]];
    for (let k = p.length - 2; k >= 0; k -= 1) {
      power = stretched(power, low.d, high.d);
      found = stretched(found, low.n, high.n).map((x, i) => x + p[k] * power[i]);
    }
    return found;
  }

  const sign = (p, x) => agreed(p.map((row) => [moved(row, x, INFINITY)[0]]))[0];
  const leading = (signs) => signs.findIndex((x) => x);
  const changes = (signs) => signs.slice(1).filter((x, i) => x !== signs[i]).length;

  /** A polynomial in x^step; `waves`: its degree in sine and cosine for each delay. */
  function factor(step, rows, delays = [], orders = []) {
    const none = [...delays, ...orders, ...orders].map(() => 0);
    let own = null;
    const slices = () => (own = own || bounds(rows));
    const signs = (a, b) => {
      const found = agreed(slices().map((p) => moved(p, a.power(step), b.power(step))));
      const n = leading(found);
      return [new Fraction(BigInt(a.n ? n : step * n)), found.slice(n)]; // at 0 the order is one in omega
    };
    const cost = rows.length ** 3 * Math.max(...rows.map((row) => row.length)) + 1000;
    return { ...summed(step, none.slice(0, delays.length), [[none, rows]]), step, rows, cost, signs, sign: (x) => sign(slices(), x.power(step)) };
  }

  /** The first two of a list, the next two, and so on. */
  const pairs = (list) => Array.from({ length: list.length / 2 }, (_, i) => [list[2 * i], list[2 * i + 1]]);

  /** What a sum of terms has in common with a polynomial: degrees, and the values of its polynomials. */
  function summed(step, waves, terms) {
    const inPi = Math.max(...terms.map(([, p]) => Math.max(...p.map((row) => row.length)))) - 1;
    const powers = terms.map(([turns]) => pairs(turns.slice(waves.length)).map(([x, y]) => x + y));
    return {
      waves,
      terms,
      isRaised: powers.some((row) => row.some((n) => n)),
      words: terms.reduce((n, [, p]) => n + p.flat().reduce((m, c) => m + 1 + Math.floor(bitsOf(c) / 64), 0), 10),
      degrees: [step * (Math.max(...terms.map(([, p]) => p.length)) - 1), inPi, ...waves, ...powers[0].map((_, i) => Math.max(...powers.map((row) => row[i])))],
      at: (x, pi) => terms.map(([turns, p]) => [turns, p.reduceRight((y, row) => y * x ** BigInt(step) + row.reduceRight((z, c) => z * pi + c, 0n), 0n)]),
    };
  }

  // Rules 7 and 8: signs of sums of polynomials times sines and cosines of omega tau/2, and powers, from Taylor's sums and his remainder.
  // Numbers are whole, in parts of one. A series has coefficients of v^n, n from 0 to ORDER, and a bound of the sum of all their errors.

  const ORDER = 14;
  const up = (n, d) => -down(-n, d);
  const factorial = (n) => (n > 1 ? BigInt(n) * factorial(n - 1) : 1n);
  const [BITS, GUARD] = [280n, 64n];
  const FINE_BITS = BITS + GUARD;
  const [PARTS_OF_ONE, FINER] = [1n << BITS, 1n << FINE_BITS];
  const partsOf = (x) => down(x.n << BITS, x.d);

  const dot = (p, q) => p.reduce((total, x, i) => total + x * q[i], 0n);
  const extent = (row) => row.reduce((n, x) => n + size(x), 0n);
  const added = (p, q) => ({ row: p.row.map((x, i) => x + q.row[i]), lost: p.lost + q.lost });

  /** Leibniz: the coefficients of a product, |p q - a b| <= |p| |q - b| + |p - a| |b|; those of p may be fewer. */
  function multiplied(p, q) {
    const [a, b] = [p.row, q.row];
    const row = b.map((_, n) => {
      let total = 0n;
      for (let k = Math.min(n, a.length - 1); k >= 0; k -= 1) total += a[k] * b[n - k];
      return total >> BITS;
    });
    return { row, lost: (((extent(a) + p.lost) * q.lost + p.lost * extent(b)) >> BITS) + BigInt(1 + b.length) };
  }

  /** cos x, -sin x, -cos x, sin x, x >= 0, to two parts of one: Taylor's sums at x/2^n < 1/2, and n times twice the angle. */
  function circle(x) {
    const n = bitsOf((2n * x.n) / x.d);
    need(n < 50, "an angle is too large");
    const y = (x.n << FINE_BITS) / (x.d << BigInt(n));
    let [c, s, term] = [FINER, 0n, FINER];
    for (let k = 1; k < 64; k += 1) {
      term = (term * y / BigInt(k)) >> FINE_BITS;
      const own = k % 4 < 2 ? term : -term;
      if (k % 2) s += own;
      else c += own;
    }
    for (let k = 0; k < n; k += 1) [c, s] = [(c * c - s * s) >> FINE_BITS, (2n * c * s) >> FINE_BITS];
    return [c, -s, -c, s].map((z) => z >> GUARD);
  }

  /** The sum of x^n/n, n odd, |x| <= 1/3, to a thousand parts of FINER. */
  function artanh(x) {
    let y = (x.n * FINER) / x.d;
    const square = (y * y) / FINER;
    let total = y;
    for (let n = 3n; n < 221n; n += 2n) {
      y = (y * square) / FINER;
      total += y / n;
    }
    return total;
  }

  const LN_2 = 2n * artanh(new Fraction(1n, 3n));

  /** x^alpha = exp(alpha ln x), x > 0 and 0 < alpha < 1, and a bound of its error; ln (1 + y)/(1 - y) = 2 artanh y. */
  function powerOf(x, alpha) {
    const bits = (k) => k.toString(2).length;
    const n = bits(x.n) - bits(x.d);
    need(x.n > 0n && Math.abs(n) < 1e5, "a number is too large, or too small");
    const m = x.over(new Fraction(2n).power(n)); // between 1/2 and 2
    const y = down((2n * artanh(m.minus(ONE).over(m.plus(ONE))) + BigInt(n) * LN_2) * alpha.n, alpha.d);
    const k = down(y, LN_2);
    let [total, term] = [FINER, FINER];
    for (let i = 1n; i < 80n; i += 1n) {
      term = (term * (y - k * LN_2)) / (FINER * i);
      total += term;
    }
    const [above, below] = [k > 0n ? k : 0n, GUARD + (k < 0n ? -k : 0n)];
    return [(total << above) >> below, ((10n ** 12n << above) >> below) + 2n]; // 2^k exp(y - k ln 2)
  }

  /** Of omega^alpha at a number, or of the sizes from low to high; of h^alpha from 0 on. */
  function binomial(alpha, low, high, step, count) {
    const ahead = low.n ? step.over(low) : ZERO;
    const weights = [ONE];
    for (let n = 1n; n < count; n += 1n) {
      weights.push(weights[weights.length - 1].times(alpha.minus(new Fraction(n - 1n))).times(ahead).over(new Fraction(n)));
    }
    const [[first, lost], [own, more]] = [low.n ? high : step, low.n ? low : step].map((x) => powerOf(x, alpha));
    const later = weights.slice(1).map((w) => down(own * w.n, w.d)).map((x) => (low.compare(high) ? size(x) : x));
    const total = weights.reduce((x, w) => x.plus(w.size), ZERO);
    return { row: [first, ...later], lost: lost + (more * total.n) / total.d + BigInt(1 + count) };
  }

  /** Of the sine and the cosine of an angle + ahead v, from its circle, or from the largest sizes of that. */
  function waving(turns, ahead, count) {
    const weights = Array.from({ length: count }, (_, n) => (ahead.n ** BigInt(n) << BITS) / (ahead.d ** BigInt(n) * factorial(n)));
    const lost = 2n * (sum(weights) >> BITS) + BigInt(2 + 2 * count);
    return [3, 0].map((i) => ({ row: weights.map((w, n) => (turns[(n + i) % 4] * w) >> BITS), lost }));
  }

  /**
   * Products of powers of omega, of each sine and its cosine, and of Re and Im of each (j omega)^alpha, as series with the step h: at a number,
   * or from low to high, where coefficients are the largest sizes of theirs. From 0 on the last two are those of h: before them is a power of
   * omega/h.
   */
  function placed(delays, orders, low, high, step) {
    const [isWide, count] = [low.compare(high) < 0, step.n ? ORDER + 1 : 1];
    const rest = Array(count - 1).fill(0n);
    const own = [{ row: [partsOf(high), partsOf(step)].slice(0, count), lost: 2n }];
    delays.forEach((tau) => {
      const rate = tau.over(new Fraction(2n));
      own.push(...waving(isWide ? Array(4).fill(PARTS_OF_ONE) : circle(high.times(rate)), step.times(rate), count));
    });
    orders.forEach((alpha) => {
      const [c, , , s] = circle(alpha.times(new Fraction(PI[0], 2n * SCALE)));
      const sizes = binomial(alpha, low, high, step, count);
      [c, s].forEach((x) => own.push(multiplied(sizes, { row: [x, ...rest], lost: 3n })));
    });
    const none = own.map(() => 0);
    const known = new Map([[none.join(), { row: [PARTS_OF_ONE, ...rest], lost: 0n }]]);
    const product = (powers) => {
      const key = powers.join();
      if (!known.has(key)) {
        const i = powers.reduce((found, n, k) => (n ? k : found), 0);
        known.set(key, multiplied(own[i], product(powers.map((n, k) => (k === i ? n - 1 : n)))));
      }
      return known.get(key);
    };
    const tables = new Map();

    /** The coefficients of the first powers of omega, side by side, with their errors and sizes. */
    function table(length) {
      if (!tables.has(length)) {
        const rows = Array.from({ length }, (_, n) => product([n, ...none.slice(1)]));
        const columns = Array.from({ length: count }, (_, n) => rows.map(({ row }) => row[n]));
        tables.set(length, [columns, rows.map(({ lost }) => lost), rows.map(({ row, lost }) => extent(row) + lost)]);
      }
      return tables.get(length);
    }

    function polynomialOf(p) {
      const [columns, errors, sizes] = table(p.length);
      const [middles, radii] = [0, 1].map((i) => p.map((x) => x[i]));
      const lost = dot(middles.map(size), errors) + dot(radii, sizes);
      return { row: columns.map((x) => dot(middles, x) >> BITS), lost: (lost >> BITS) + BigInt(1 + count) };
    }

    return (terms) => terms.map(([powers, p]) => multiplied(polynomialOf(p), product(powers.slice(0, own.length)))).reduce(added);
  }

  /** The last few of them, as many factors ask for the same ones. */
  const places = new Map();

  /** The series of a sum of terms. */
  function seriesOf(terms, delays, orders, low, high, step) {
    const key = [delays, orders, [low, high, step]].map((list) => list.map((x) => `${x.n}/${x.d}`).join()).join(";");
    if (!places.has(key)) {
      if (places.size > 7) places.delete(places.keys().next().value);
      places.set(key, placed(delays, orders, low, high, step));
    }
    return places.get(key)(terms);
  }

  /** Of 1, v, v^2, ...: Bernstein's coefficients on [-1, 1], times those of (1 + u)^n, with which each row begins. */
  const bernsteins = new Map();

  function bernstein(count) {
    if (!bernsteins.has(count)) {
      const units = Array.from({ length: count }, (_, n) => moved(Array.from({ length: count }, (_, k) => BigInt(k === n)), new Fraction(-1n), ONE));
      bernsteins.set(count, units.map((_, i) => units.map((x) => x[i])));
    }
    return bernsteins.get(count);
  }

  /** The sign for all v from -1 to 1, if Bernstein's coefficients show it; else 0. */
  function steady(row, lost) {
    const found = bernstein(row.length).map((x) => [dot(row, x), lost * x[0]]);
    return found.every(([x, most]) => x > most) ? 1 : found.every(([x, most]) => x < -most) ? -1 : 0;
  }

  /** The sign of a number. */
  function strict(x, lost) {
    need(size(x) > lost, "a sign stays open");
    return x > 0n ? 1 : -1;
  }

  const powersOfPi = new Map();

  function powerOfPi(n) {
    if (!powersOfPi.has(n)) {
      const [low, high] = PI.map((x) => (x ** BigInt(n) * PARTS_OF_ONE) / SCALE ** BigInt(n));
      powersOfPi.set(n, [low, high - low + 1n]);
    }
    return powersOfPi.get(n);
  }

  const inPi = (row) => [sum(row.map((c, n) => c * powerOfPi(n)[0])), sum(row.map((c, n) => size(c) * powerOfPi(n)[1]))];

  /**
   * A sum of polynomials in omega times powers of sines, of cosines with what is missing to a degree, of omega tau/2, and of Re and Im of
   * (j omega)^alpha.
   */
  function waveFactor(x, delays, orders) {
    const [told, rows] = keyed(x, "waves", "terms");
    const waves = listed(told, delays.length, delays.length).map((n) => whole(n, 0, 40));
    const most = [...waves, ...orders.flatMap(() => [40, 40])];
    const terms = listed(rows, 300, 1).map((row) => {
      const [turns, p] = listed(row, 2, 2);
      return [listed(turns, most.length, most.length).map((k, i) => whole(k, 0, most[i])), polynomial(p)];
    });
    need(new Set(terms.map(([turns]) => turns.join())).size === terms.length, "a term stands twice in a factor");
    const every = terms.flatMap(([, p]) => p);
    const common = summed(1, waves, terms);
    const sizes = every.reduce((n, row) => n + Math.max(...row.map(bitsOf)) + row.length + 40, 0);
    const cost = (sizes + 500 * terms.length * common.degrees.slice(2).reduce((n, k) => n + k, 1)) * 2;
    need(cost < 1e7, "a factor is too large");
    return waved(waves, terms, delays, orders, common, cost);
  }

  /** The same from what is told of it. */
  function waved(waves, terms, delays, orders, common, cost) {
    /** Exponents of omega, of sines and cosines, and of real and imaginary parts, with coefficients; `number`: what one is, with pi in it. */
    const numbers = (some, number = inPi) =>
      some.map(([turns, p]) => [[0, ...waves.flatMap((n, i) => [turns[i], n - turns[i]]), ...turns.slice(waves.length)], p.map(number)]);

    /** With cosines alone, whose largest sizes are those of sines. */
    function sized(some) {
      const cosines = waves.flatMap((n) => [0, n]);
      const found = new Map();
      some.forEach(([powers, p]) => {
        const turns = [0, ...cosines, ...powers.slice(1 + cosines.length)];
        const [, own] = found.get(turns.join()) || [turns, []];
        p.forEach(([m, r], n) => { own[n] = [(n < own.length ? own[n][0] : 0n) + size(m) + r, 0n]; });
        found.set(turns.join(), [turns, own]);
      });
      return [...found.values()];
    }

    /** All c_n, n < ORDER, and what the sum of c_n v^n, v from -1 to 1 (0 to 1 from 0 on), is off that of terms by at most (Lagrange). */
    function modelOf(some, a, b) {
      const middle = a.n ? a.plus(b).over(new Fraction(2n)) : a;
      const [here, largest] = [[some, middle, middle], [sized(some), a, b]].map(([x, low, high]) => seriesOf(x, delays, orders, low, high, b.minus(middle)));
      return [here.row.slice(0, -1), here.lost + largest.row[ORDER] + largest.lost];
    }

    /**
     * The terms with each power of omega that is not whole, and which of Taylor's coefficients are not zero beside it at 0. With a step that
     * makes all angles multiples of ORDER! coefficients are whole numbers; each power of pi in them is looked at alone.
     */
    function beginnings() {
      const step = new Fraction(2n * factorial(ORDER) * delays.reduce((n, { d }) => (n / divisor(n, d)) * d, 1n));
      const groups = new Map();
      terms.forEach((term) => {
        const key = term[0].slice(waves.length).join();
        groups.set(key, [...(groups.get(key) || []), term]);
      });
      return [...groups.values()].map((some) => {
        const width = Math.max(...some.flatMap(([, p]) => p).map((row) => row.length));
        const alone = Array.from({ length: width }, (_, i) => numbers(some, (row) => [(row[i] || 0n) * PARTS_OF_ONE, 0n]));
        const found = alone.map((own) => seriesOf(own, delays, [], ZERO, ZERO, step).row);
        const exponent = pairs(some[0][0].slice(waves.length)).reduce((n, [k, m], i) => n.plus(orders[i].times(new Fraction(BigInt(k + m)))), ZERO);
        return { exponent, some: numbers(some), there: found[0].map((_, n) => n === ORDER || found.some((row) => row[n])) };
      });
    }

    /** A sum of c v^e, v from 0 to 1, has one sign if all of its partial sums have, from the lowest e on (Abel). */
    function signsFrom0(b) {
      first = first || beginnings();
      const total = [];
      let lost = 0n;
      first.forEach(({ exponent, some, there }) => {
        const [row, more] = modelOf(some, ZERO, b);
        lost += more;
        [...row, 0n].forEach((c, n) => {
          if (!there[n]) return;
          const own = exponent.plus(new Fraction(BigInt(n)));
          const known = total.find((x) => x.own.compare(own) === 0);
          if (known) known.c += c;
          else total.push({ own, c });
        });
      });
      total.sort((x, y) => x.own.compare(y.own));
      let partial = 0n;
      const found = total.map(({ c }) => strict((partial += c), lost));
      need(found.every((x) => x === found[0]), "a sign stays open");
      return [total[0].own, [found[0]]];
    }

    const all = numbers(terms);
    let first = null;
    return {
      ...common,
      cost,
      signs(a, b) {
        if (!a.n) return signsFrom0(b);
        const [row, lost] = modelOf(all, a, b);
        const found = steady(row, lost);
        if (found) return [ZERO, [found]];
        need(steady(row.map((c, n) => BigInt(n) * c).slice(1), BigInt(ORDER) * lost), "a sign stays open");
        return [ZERO, [sum(row.map((c, n) => (n % 2 ? -c : c))), sum(row)].map((x) => strict(x, lost))];
      },
      sign(at) {
        const { row, lost } = seriesOf(all, delays, orders, at, at, ZERO);
        return strict(row[0], lost);
      },

      /** With other coefficients. */
      refilled(coefficients) {
        let used = 0;
        const others = terms.map(([turns, p]) => [turns, p.map(() => [coefficients[used++]])]);
        return waved(waves, others, delays, orders, {}, 0);
      },
    };
  }

  function factorOf(x, delays, orders) {
    if (x && typeof x === "object" && "waves" in x) return waveFactor(x, delays, orders);
    const [step, p] = keyed(x, "step", "polynomial");
    return factor(whole(step, 1, 2), polynomial(p), delays, orders);
  }

  /** Bounds of the low end of the band, and of the high end. */
  function endsOf(scene) {
    const [low, high] = scene.band.map((x) => PI.map((pi) => x.value.times(new Fraction(pi, SCALE).power(x.pi))).sort((x, y) => x.compare(y)));
    need(low[1].compare(high[0]) < 0, "the band is empty");
    return [low, high];
  }

  /** That signs, with that cost where numbers have one bit, are soon found at all of some numbers. */
  function affordable(numbers, cost) {
    const bits = numbers.reduce((n, x) => n + bitsOf(x.d) + bitsOf(x.n), 0);
    need(bits * cost < 5e9, "the cells are too many, or too fine");
  }

  /** The places of the band in order, with the orders of all factors there, and their signs in between. */
  function charted(scene, points, factors, told) {
    const ends = endsOf(scene);
    const [[low, lowTop], [high, highTop]] = ends;
    const last = points.length - 1;
    const ascend = (...list) => list.every((x, i) => !i || list[i - 1].compare(x) <= 0);
    need(ascend(ZERO, points[0], low) && ascend(lowTop, points[1]), "the first cell does not hold the low end of the band");
    need(ascend(points[last - 1], high) && ascend(highTop, points[last]), "the last cell does not hold the high end of the band");
    affordable(points, factors.reduce((n, { cost }) => n + cost, 0));
    affordable(told.flat(), Math.floor(Math.max(0, ...factors.map(({ cost }) => cost)) / 10));
    const chart = { from0: lowTop.n === 0n, isRaised: factors.map((x) => x.isRaised), orders: [new Map()], signs: [] };
    const trailing = new Map();
    let used = 1;
    need(told.length > 1 && ascend(told[0][0], low) && ascend(lowTop, told[0][1]), "the low end of the band is not in its enclosure");
    for (let k = 0; k < last; k += 1) {
      const [a, b] = [points[k], points[k + 1]];
      const starts = low.compare(a) === 0 && lowTop.compare(a) === 0;
      const stops = high.compare(b) === 0 && highTop.compare(b) === 0;
      const both = factors.map((f) => f.signs(a, b));
      const [leads, found] = [0, 1].map((i) => both.map((x) => x[i]));
      const inner = found.map((signs) => signs.filter((x) => x));
      found.forEach((signs, i) => {
        const [lead, trail] = [leads[i], leading([...signs].reverse())];
        need((starts || !lead.n) && (stops || !trail), "a factor is zero at a breakpoint");
        if (lead.n) chart.orders[0].set(i, lead);
        if (trail) trailing.set(i, new Fraction(BigInt(trail)));
      });
      if (!chart.signs.length) chart.signs.push(inner.map((x) => x[0]));
      const turns = inner.map(changes);
      const beside = (k === 0 && !starts) || (k === last - 1 && !stops);
      need(turns.reduce((x, y) => x + y, 0) <= (beside ? 0 : 1), "a cell may hold two zeros, or one beside an end of the band");
      const i = turns.indexOf(1);
      if (i >= 0) {
        need(used < told.length, "there are more places than frequencies");
        const [x, y] = told[used];
        used += 1;
        need(a.compare(x) < 0 && ascend(x, y) && y.compare(b) < 0 && factors[i].sign(x) * factors[i].sign(y) <= 0, "an enclosure holds no zero");
        chart.orders.push(new Map([[i, ONE]]));
        chart.signs.push(inner.map((s) => s[s.length - 1]));
      }
    }
    chart.orders.push(trailing);
    need(used === told.length - 1, "there are not as many frequencies as places");
    need(ascend(told[used][0], high) && ascend(highTop, told[used][1]), "the high end of the band is not in its enclosure");
    return chart;
  }

  // Rule 4: what follows.

  /** A whole number, rounded away from 0. */
  const away = (x) => Number(x.n > 0n ? up(x.n, x.d) : down(x.n, x.d));

  function curve(p, chart) {
    const order = chart.orders.map((found) => away([...p.powers].reduce((x, [f, n]) => x.plus((found.get(f) || ZERO).times(new Fraction(BigInt(n)))), ZERO)));
    const isOneSided = chart.from0 && [...p.powers.keys()].some((f) => chart.isRaised[f]); // a power of omega has no other side
    const between = chart.signs.map((row) => [...p.powers].reduce((x, [f, n]) => x * (n % 2 ? row[f] : 1), signOf(p.number.n)));
    const flip = (x, n) => (n % 2 ? -x : x) || 0;
    const before = [flip(between[0], isOneSided ? 0 : order[0]), ...between];
    const after = [...between, flip(between[between.length - 1], order[order.length - 1])];
    return { order, before, after, at: order.map((n, i) => (n > 0 || before[i] !== after[i] ? 0 : after[i])) };
  }

  /** As few closed intervals as possible, of places and of what is between: where all curves pass. */
  function where(test, ...curves) {
    const [here, next] = ["at", "after"].map((key) => curves[0][key].map((_, i) => curves.every((c) => test(c[key][i]))));
    const found = [];
    here.forEach((passes, i) => {
      if (passes && !(i && next[i - 1])) found.push([i, i]);
      if (i + 1 < here.length && next[i]) {
        if (passes) found[found.length - 1][1] = i + 1;
        else found.push([i, i + 1]);
      }
    });
    return found;
  }

  const PROPERTIES = { "1,1": "stiffness", "-1,-1": "mass", "1,-1": "stiffness-to-mass", "-1,1": "mass-to-stiffness" };

  function percepts(curves, part) {
    const [env, perc, excess, change, both] = CURVES.map((name) => curves[`${name}.${part}`]);
    const found = [];
    for (let i = 0; i + 1 < env.order.length; i += 1) {
      const [x, y] = [env.after[i], perc.after[i]];
      if (!(excess.after[i] > 0 && (part === "real" || y >= 0))) continue;
      const property = part === "imag" ? "damping" : PROPERTIES[[x || y, y || x].join()];
      const compared = { 1: "higher", 0: "equal", "-1": "lower" }[change.after[i] * both.after[i]];
      const last = found[found.length - 1];
      if (last && last.to === i && last.property === property && last.change === compared && excess.at[i] > 0) last.to = i + 1;
      else found.push({ part, from: i, to: i + 1, property, change: compared });
    }
    return found;
  }

  function claimed(curves, from0) {
    const places = curves["excess.real"].order.map((_, i) => i);
    const crossings = [];
    places.forEach((i) => PARTS.forEach((part) => {
      const c = curves[`excess.${part}`];
      if (c.order[i] <= 0) return;
      const touches = c.before[i] === c.after[i] && !(i === 0 && from0 && c.after[i] > 0);
      const kind = touches ? "touches" : c.after[i] > 0 ? "exceeds" : "returns";
      crossings.push({ at: i, part, kind, sign: curves[`difference.${part}`].after[i], multiplicity: c.order[i] });
    }));
    const excess = PARTS.map((part) => curves[`excess.${part}`]);
    const turns = (name) => places.filter((i) => curves[`${name}.real`].before[i] * curves[`${name}.real`].after[i] < 0);
    return {
      crossings,
      transparent: where((x) => x <= 0, ...excess),
      changeovers: { environment: turns("environment"), perceived: turns("perceived") },
      percepts: PARTS.flatMap((part) => percepts(curves, part)),
      outside_model: where((x) => x < 0, curves["perceived.imag"]),
      unbounded: places.filter((i) => excess.some((c) => c.order[i] < 0)),
    };
  }

  // Rule 5: zeros in Re s >= 0.

  const PRIME = 2n ** 61n - 1n;
  const residue = (n) => ((n % PRIME) + PRIME) % PRIME;

  /** 1/x modulo the prime (Fermat). */
  function inverse(x) {
    let [found, power, left] = [1n, x, PRIME - 2n];
    for (; left; left >>= 1n) {
      if (left & 1n) found = residue(found * power);
      power = residue(power * power);
    }
    return found;
  }

  /** Whether p and q have no zero in common, not even with 3 in place of pi and modulo a prime. */
  function coprime(p, q) {
    let [a, b] = [p, q].map((rows) => rows.map((row) => residue(sum(row.map((c, i) => c * 3n ** BigInt(i))))));
    if (!a[a.length - 1] || !b[b.length - 1]) return false;
    while (b.length) {
      while (a.length >= b.length) {
        const by = residue(a[a.length - 1] * inverse(b[b.length - 1]));
        const shift = a.length - b.length;
        a = a.map((x, i) => (i < shift ? x : residue(x - by * b[i - shift])));
        while (a.length && !a[a.length - 1]) a.pop();
      }
      [a, b] = [b, a];
    }
    return a.length === 1;
  }

  /** The zeros of p in Re s >= 0: that at 0, and what the turns of p(j omega) = E + j omega O between points of omega^2 tell. */
  function toTheRight(told, points) {
    const at0 = leading(told.map((row) => row.some((c) => c)));
    const p = told.slice(at0);
    const [even, odd] = [0, 1].map((i) => {
      const half = p.filter((_, k) => k % 2 === i).map((row, k) => row.map((c) => (k % 2 ? -c : c)));
      return bounds(half.length ? half : [[0n]]);
    });
    const ends = [ZERO, ...points, INFINITY];
    let [left, last] = [0, 0];
    ends.slice(1).forEach((high, k) => {
      const [e, o] = [even, odd].map((rows) => agreed(rows.map((row) => moved(row, ends[k], high))));
      need(e[0] && (e[e.length - 1] || high === INFINITY), "E is zero between two cells");
      const [inner, side] = [e.filter((x) => x), o.filter((x) => x)];
      const turns = changes(inner);
      need(turns + changes(side) < 2 || !turns, "a cell may hold two zeros");
      left += 2 * turns * (side.length ? e[0] * side[0] : -1);
      last = inner[inner.length - 1] * (side.length ? side[side.length - 1] : 0);
    });
    const n = p.length - 1;
    return at0 + (n - left - (n % 2) * last) / 2;
  }

  /** The zeros in Re s >= 0 of a function of s and pi, counted with multiplicity. */
  function zeros(x, ratio, length, share = 1) {
    const [told, own, cells] = keyed(x, "factors", "function", "cells");
    const factors = listed(told, 100).map(polynomial);
    const linked = factors.map((rows) => factor(1, rows));
    const p = product(own, linked);
    link({ it: p }, linked, (s, pi) => ({ it: ratio(point([value(s, 0n, degree(0, 1)), UNIT], pi)) }), length, [], [], share);
    need(p.number.n, "a function is zero everywhere");
    const points = listed(cells, factors.length, factors.length).map((row) => ascending(row, 300));
    need(points.every((row) => !row.length || row[0].n > 0n), "a cell is empty");
    p.powers.forEach((_, i) => affordable([ZERO, ...points[i]], linked[i].cost * linked.length * share));
    const below = [...p.powers].filter(([, n]) => n < 0).map(([i]) => factors[i]);
    return [...p.powers].filter(([, n]) => n > 0).reduce((count, [i, n]) => {
      const found = toTheRight(factors[i], points[i]);
      need(!found || below.every((q) => coprime(factors[i], q)), "a zero may be none: the denominator may share it");
      return count + n * found;
    }, 0);
  }

  // Rule 6: for which values of a free parameter a display is transparent.

  /** Polynomials whose sum, with positive weights, p is for every value between two. */
  function sliced(p, low, high) {
    const width = Math.max(...p.map((row) => row.length));
    const rows = p.map((row) => moved([...row, ...Array(width - row.length).fill(0n)], low, high));
    return rows[0].map((_, i) => rows.map((row) => row[i]));
  }

  /** The slices of a factor between two values: functions of omega alone. */
  function slicesOf(f, low, high) {
    const bits = [low.n, low.d, high.n, high.d].reduce((n, x) => n + bitsOf(x), 0);
    need(bits * (f.degrees[1] + 1) < 1e5, "the ends of a slab are too long");
    const every = sliced(f.terms.flatMap(([, p]) => p), low, high);
    const waves = f.refilled ? every.map((row) => (row.some((c) => c) ? f.refilled(row) : null)) : null;
    const known = new Map();

    /** The signs that each may have from a to b; none where it is zero everywhere. */
    function signs(a, b) {
      const isPoint = a.compare(b) === 0;
      if (waves) return waves.map((x) => (!x ? [] : isPoint ? [x.sign(a)] : x.signs(a, b)[1]));
      const [start, end] = [a, b].map((x) => x.power(f.step));
      return every.map((row) => moved(row, start, end).map(signOf).filter((x) => x));
    }

    /** The sign from a to b, for all values between those two; `closed`: for which of these it must have it as well. */
    return (a, b, closed) => {
      const key = [a, b].map((x) => `${x.n}/${x.d}`).join();
      if (!known.has(key)) known.set(key, signs(a, b));
      const own = known.get(key);
      const found = new Set(own.flat());
      need(found.size === 1, "a sign is not proven");
      need((own[0].length || !closed[0]) && (own[own.length - 1].length || !closed[1]), "a factor may be zero");
      return [...found][0];
    };
  }

  /** What it costs to find their signs, as the limits have it: for each bit of a point, and with waves for each point. */
  function costOfSlices(f) {
    const [count, width] = [f.terms.reduce((n, [, p]) => n + p.length, 0), f.degrees[1] + 1];
    return f.refilled ? [2 * count * width ** 2, f.cost * width] : [2 * (count * width) ** 2 + 2000, 0];
  }

  /** That no excess is positive anywhere on the band, or that the one of a part is at some point of it. */
  function verify(told, slices, closed, points, part, band) {
    const at = ascending(points, 500, 1);
    const sign = (x, a, b, firm) => [...x.powers].reduce((found, [i, n]) => {
      const one = slices[i](a, b, firm || n < 0 ? closed : [false, false]);
      return n % 2 ? found * one : found;
    }, signOf(x.number.n));
    if (part === null) {
      need(at[0].n >= 0n && at[0].compare(band[0][0]) <= 0 && at[at.length - 1].compare(band[1][1]) >= 0, "the cells do not hold the band");
      at.slice(1).forEach((b, i) => {
        need(Object.values(told).every((x) => sign(x, at[i], b, false) <= 0), "an excess may be positive");
      });
      return;
    }
    const x = PARTS.includes(part) && told[`excess.${part}`];
    need(x && at.length === 1 && at[0].compare(band[0][1]) >= 0 && at[0].compare(band[1][0]) <= 0, "a point is not on the band");
    need(sign(x, at[0], at[0], true) > 0, "an excess may not be positive");
  }

  const isLess = (x, y) => x.n * y.d < y.n * x.d;

  /** Intervals of values, ascending, each with whether the display is transparent for them; and which parts bind between them. */
  function valuesOf(told, factors, slabs, scene) {
    const rows = listed(slabs, 500, 1).map((x) => keyed(x, "from", "to", "points", "part"));
    const triples = rows.flatMap(([low, high, points]) => listed(points, 500, 1).map((x) => [low, high, x]));
    const [cost, costOfWaves] = [0, 1].map((i) => factors.reduce((n, f) => n + costOfSlices(f)[i], 0));
    affordable(triples.flat().filter((x) => x !== null).map(number), cost);
    need(triples.length * costOfWaves < 1e8, "the cells are too many for factors with waves");
    const joined = (i) => i > 0 && i < rows.length && rows[i - 1][1] === rows[i][0] && (rows[i - 1][3] === null) === (rows[i][3] === null);
    const point = (x, infinity) => (x === null ? { n: infinity, d: 0n } : number(x));
    const band = endsOf(scene);
    const binds = [];
    const values = rows.reduce((found, [low, high, points, part], i) => {
      const [start, end, last] = [point(low, -1n), point(high, 1n), found[found.length - 1]];
      need(isLess(start, end) && !(last && (low === null || isLess(start, point(last[1], 1n)))), "the slabs do not ascend");
      need(joined(i) || !last || last[2] !== (part === null), "between two slabs there is more than an end");
      const slices = factors.map((f) => slicesOf(f, start, end));
      verify(told, slices, [joined(i), joined(i + 1)], points, part, band);
      if (last && !joined(i)) binds.push(part === null ? rows[i - 1][3] : part);
      return joined(i) ? [...found.slice(0, -1), [last[0], high, part === null]] : [...found, [low, high, part === null]];
    }, []);
    return { values, binds };
  }

  // The questions that a certificate may answer, each with what follows from its proof.

  /** Delays and orders. */
  function othersOf(...told) {
    const both = told.map((row) => listed(row, MOST_OTHERS).map(number));
    need(both.flat().every((x) => x.n > 0n && x.n < x.d << 100n && x.d < 1n << 100n), "a delay is not positive, or too long");
    const fits = both.flat().length <= MOST_OTHERS && both[1].every((x) => x.compare(ONE) < 0);
    need(fits, "there are too many delays and orders, or an order is not below 1");
    return both;
  }

  function evaluation(claim, proof, scene) {
    const [lags, powers, points, told, products, poles] = keyed(proof, "delays", "orders", "breakpoints", "factors", "functions", "poles");
    const [delays, orders] = othersOf(lags, powers);
    const factors = listed(told, 500).map((x) => factorOf(x, delays, orders));
    need(isSquare(scene.region), "the JND is a region of its own");
    const names = CURVES.flatMap((x) => PARTS.map((part) => `${x}.${part}`));
    const written = keyed(products, ...names).map((x) => product(x, factors));
    link(Object.fromEntries(names.map((x, i) => [x, written[i]])), factors, (x, pi, others) => functions(scene, onAxis(x, pi, delays, orders, others)), scene.length, delays, orders);
    const enclosures = listed(claim.frequencies, 2000, 2).map((pair) => listed(pair, 2, 2).map(number));
    const chart = charted(scene, ascending(points, 2000, 2), factors, enclosures);
    const curves = Object.fromEntries(names.map((x, i) => [x, curve(written[i], chart)]));
    const count = poles === null ? null : zeros(poles, (where) => [...scene.at(where)[1]].reverse(), scene.length);
    return { frequencies: claim.frequencies, ...claimed(curves, chart.from0), stable: count === null ? null : count === 0 };
  }

  function stability(claim, proof, scene) {
    const [poles, held] = keyed(proof, "imposed", "held");
    const told = listed(claim.held, 100);
    const proofs = listed(held, told.length, told.length);
    const asked = [scene.length, 1 + told.length];
    const count = zeros(poles, (where) => [...scene.at(where)[1]].reverse(), ...asked);
    const found = told.map((row, i) => {
      const [hand] = keyed(row, "hand", "unstable");
      const numbers = typeof hand === "string" ? null : keyed(hand, "m", "b", "k").map(number);
      const z = scene.hand(hand, numbers);
      return { hand, unstable: zeros(proofs[i], (where) => combined("+", scene.at(where)[1], z(where)), ...asked) };
    });
    return { imposed: count, held: found };
  }

  function requirement(claim, proof, scene) {
    const isObject = proof && typeof proof === "object" && !Array.isArray(proof);
    const [lags, powers, every, products, slabs] = keyed(isObject ? { delays: [], orders: [], ...proof } : null, "delays", "orders", "factors", "functions", "slabs");
    const [delays, orders] = othersOf(lags, powers);
    const asked = listed(claim.parts, 2, 1);
    const parts = PARTS.filter((part) => asked.includes(part));
    need(isSquare(scene.region), "the JND is a region of its own");
    const [free, names] = [listed(claim.free, 9, 1), parts.map((part) => `excess.${part}`)];
    const factors = listed(every, 500).map((x) => factorOf(x, delays, orders));
    const written = keyed(products, ...names).map((x) => product(x, factors));
    const told = Object.fromEntries(names.map((x, i) => [x, written[i]]));
    link(told, factors, (x, pi, others) => {
      const found = functions(scene, onAxis(x, pi, delays, orders, others));
      return Object.fromEntries(names.map((name) => [name, found[name]]));
    }, scene.length, delays, orders);
    return { free, parts, ...valuesOf(told, factors, slabs, scene) };
  }

  const QUESTIONS = { evaluation, stability, requirement };

  const sorted = (x) => JSON.stringify(x, (_, y) => (y && typeof y === "object" && !Array.isArray(y) ? Object.fromEntries(Object.entries(y).sort()) : y));

  /** The claim, if the certificate proves it for that scene; a Refused error, and why, if not. */
  function check(text, sceneText, catalogue) {
    const [kind, digest, name, claim, proof] = keyed(json(text), "format", "scene_sha256", "environment", "claim", "proof");
    need(kind === "haptisym.certificate/1", "the format is not haptisym.certificate/1");
    need(new TextEncoder().encode(sceneText).length <= 1e6, "the scene is too large");
    need(digest === sha256(sceneText), "the certificate is that of another scene file");
    need(name === null || typeof name === "string", "the environment has no name");
    const asked = claim && typeof claim === "object" && Object.keys(QUESTIONS).includes(claim.question);
    need(asked, "the claim answers no question that is known");
    const follows = QUESTIONS[claim.question](claim, proof, reader(catalogue)(sceneText, name, "free" in claim ? listed(claim.free, 9, 1) : null));
    keyed(claim, "question", ...Object.keys(follows));
    Object.entries(follows).forEach(([key, x]) => need(sorted(claim[key]) === sorted(x), `${key}: something else is proven than what is claimed`));
    return claim;
  }

  /** The same, with words instead of errors: `claim` is null where it is not proven. */
  function verdict(text, sceneText, catalogue) {
    try {
      return { claim: check(text, sceneText, catalogue), why: "" };
    } catch (error) {
      if (error instanceof Refused || error instanceof RangeError) return { claim: null, why: error.message };
      throw error;
    }
  }

  // Crossings at other values of a scene's parameters, for the explorer: found by the rules that prove those of a certificate.

  const trimmed = (p) => p.slice(0, p.length - [...p].reverse().findIndex((c) => c) || 0);

  function primitive(p) {
    const by = p.reduce(divisor, 0n);
    return by ? p.map((c) => c / by) : p;
  }

  /** The remainder of a by b, times a number. */
  function remainder(a, b) {
    let rest = a;
    while (rest.length >= b.length) {
      const [top, lead, shift] = [rest[rest.length - 1], b[b.length - 1], rest.length - b.length];
      rest = rest.map((c, i) => c * lead - (i >= shift ? top * b[i - shift] : 0n)).slice(0, -1);
      rest = rest.some((c) => c) ? primitive(trimmed(rest)) : [];
    }
    return rest;
  }

  function common(a, b) {
    if (a.length && b.length && coprime(a.map((c) => [c]), b.map((c) => [c]))) return [1n];
    let [x, y] = [primitive(a), primitive(b)];
    while (y.length) [x, y] = [y, remainder(x, y)];
    return x;
  }

  /** a/b, where b divides a but for a number. */
  function quotient(a, b) {
    if (b.length === 1) return primitive(a);
    const found = [];
    let rest = a.map((c) => new Fraction(c));
    while (rest.length >= b.length) {
      const [by, shift] = [rest[rest.length - 1].over(new Fraction(b[b.length - 1])), rest.length - b.length];
      found.unshift(by);
      rest = rest.map((c, i) => (i >= shift ? c.minus(by.times(new Fraction(b[i - shift]))) : c)).slice(0, -1);
    }
    return cleared(found);
  }

  function cleared(p) {
    const scale = p.reduce((x, c) => (x * c.d) / divisor(x, c.d), 1n);
    return primitive(p.map((c) => (c.n * scale) / c.d));
  }

  const slope = (p) => p.slice(1).map((c, i) => c * BigInt(i + 1));

  /** The factors of odd multiplicity, each simple (Yun): where p changes its sign, one of them has a zero. */
  function odd(p) {
    const found = [];
    let left = common(p, p.length > 1 ? slope(p) : [1n]);
    let simple = quotient(p, left);
    for (let n = 1; simple.length > 1; n += 1) {
      const next = left.length > 1 ? common(simple, left) : [1n];
      const own = quotient(simple, next);
      if (n % 2 && own.length > 1) found.push(own);
      [simple, left] = [next, quotient(left, next)];
    }
    return found;
  }

  /** Intervals that hold one zero each, of a polynomial with simple zeros; all of those strictly between a and b (Vincent). */
  function isolated(p, a, b) {
    const turns = changes(moved(p, a, b).map(signOf).filter((x) => x));
    if (turns === 0) return [];
    if (turns === 1) return [[a, b]];
    const middle = cut(p, a, b);
    return [...isolated(p, a, middle), ...isolated(p, middle, b)];
  }

  /** About the middle, where p is not zero. */
  function cut(p, a, b) {
    let middle = a.plus(b).over(new Fraction(2n));
    for (let n = 3n; sign([p], middle) === 0; n += 1n) middle = a.plus(b.minus(a).over(new Fraction(n)));
    return middle;
  }

  function refined(p, [a, b]) {
    const first = moved(p, a, b).map(signOf).find((x) => x);
    let [low, high] = [a, b];
    while (high.minus(low).times(new Fraction(10n ** 9n)).compare(high) > 0) {
      const middle = cut(p, low, high);
      if (sign([p], middle) === first) low = middle;
      else high = middle;
    }
    return [low, high];
  }

  /** A polynomial in omega^step with whole coefficients, but for a positive number: by its values (Newton). */
  function interpolated(f, step) {
    const degree = Math.max(0, Math.floor(f(0n).degrees[0] / step));
    need(degree <= (step === 2 ? 20 : 40), "the degrees are too high for that");
    const nodes = Array.from({ length: degree + 1 }, (_, k) => new Fraction(BigInt(k ** step)));
    let column = nodes.map((_, k) => new Fraction(f(BigInt(k)).re));
    const weights = [column[0]];
    for (let n = 1; n <= degree; n += 1) {
      column = column.slice(1).map((y, i) => y.minus(column[i]).over(nodes[i + n].minus(nodes[i])));
      weights.push(column[0]);
    }
    let found = [];
    for (let n = degree; n >= 0; n -= 1) { // times (W - node), plus the next weight
      found = [ZERO, ...found].map((c, i) => (i < found.length ? c.minus(found[i].times(nodes[n])) : c));
      found[0] = found[0].plus(weights[n]);
    }
    return found.some((c) => c.n) ? trimmed(cleared(found)) : [];
  }

  /** Polynomials, no two with a common zero and each with simple ones, that vanish wherever one of some changes its sign. */
  function separate(polynomials) {
    return polynomials.flatMap((p) => (p.length > 1 ? odd(p) : [])).reduce((found, p) => {
      const rest = found.reduce((q, known) => {
        const shared = q.length > 1 ? common(q, known) : [1n];
        return shared.length > 1 ? quotient(q, shared) : q;
      }, p);
      return rest.length > 1 ? [...found, rest] : found;
    }, []);
  }

  /** Cells that hold one zero each of polynomials without common zeros: all those between a and b, ascending, no two with a point in common. */
  function cellsOf(polynomials, a, b) {
    const inside = ([low, high]) => low.compare(a) > 0 && high.compare(b) < 0;
    let cells = polynomials.flatMap((p) => isolated(p, a, b).map((cell) => ({ p, cell: refined(p, cell) })));
    for (let round = 0; round < 200; round += 1) {
      cells.sort((x, y) => x.cell[0].compare(y.cell[0]));
      const apart = cells.map(({ cell }, i) => inside(cell) && (!i || cells[i - 1].cell[1].compare(cell[0]) < 0) && (i + 1 === cells.length || cell[1].compare(cells[i + 1].cell[0]) < 0));
      if (apart.every((x) => x)) return cells.map(({ cell }) => cell);
      cells = cells.map(({ p, cell }, i) => ({ p, cell: apart[i] ? cell : halved(p, cell) }));
    }
    need(false, "two frequencies lie too close together");
    return [];
  }

  function halved(p, [low, high]) {
    const middle = cut(p, low, high);
    return sign([p], middle) === moved(p, low, high).map(signOf).find((x) => x) ? [middle, high] : [low, middle];
  }

  /** Where what is judged, terms of polynomials, becomes positive between a and b, or stops being so; ascending. */
  function signChanges(terms, a, b) {
    const cells = cellsOf(separate(terms.flat()), a, b);
    const ends = [a, ...cells.map((cell) => cell[1])];
    const starts = [...cells.map((cell) => cell[0]), b];
    const isOutside = ends.map((x, i) => {
      const between = x.plus(starts[i]).over(new Fraction(2n)); // there no polynomial changes its sign
      return terms.some((term) => term.every((p) => p.length && signBeside(p, between, starts[i]) > 0));
    });
    return cells.map((cell, i) => ({ cell, rising: isOutside[i + 1], was: isOutside[i] })).filter(({ rising, was }) => rising !== was);
  }

  /** The sign of p, not zero everywhere, between two points between which it does not change. */
  function signBeside(p, at, end) {
    let x = at;
    while (sign([p], x) === 0) x = x.plus(end).over(new Fraction(2n));
    return sign([p], x);
  }

  /** The omega, a float, of a cell in omega^step. */
  function root([low, high], step) {
    const x = Number((low.plus(high).n * 10n ** 30n) / (low.plus(high).d * 2n)) / 1e30;
    return step === 2 ? Math.sqrt(x) : x;
  }

  /** A JND with other decimals for some of its numbers. */
  function withLimits(region, given) {
    const limits = new Map(region.limits);
    const { size, ...others } = given;
    Object.entries(others).forEach(([key, text]) => {
      need(limits.has(key), "a limit is none of the scene");
      limits.set(key, quantityOf(decimal(text)));
    });
    return { ...region, limits, scale: size === undefined ? null : quantityOf(decimal(size)) };
  }

  /** The polynomials of what is judged, by the criterion, each with the sign of its function; `step`: in which power of omega. */
  function polynomialsOf(scene, step) {
    const known = new Map();
    const at = (omega) => known.get(omega) || known.set(omega, functions(scene, onAxis(omega, 1n))).get(omega);
    const found = {};
    Object.keys(at(0n)).filter((x) => x.startsWith("excess.")).forEach((name) => {
      const [, criterion, term, place] = name.split(".");
      const isEdge = scene.region.shape === "polygon" && place === "0"; // elsewhere what stands below is a square
      const f = (omega) => (isEdge ? times(...at(omega)[name]) : at(omega)[name][0]);
      need(f(0n).degrees[1] <= 0, "pi is among the numbers");
      const terms = found[criterion] || (found[criterion] = []);
      const i = Number(term || 0);
      (terms[i] || (terms[i] = [])).push(interpolated(f, step));
    });
    return found;
  }

  /**
   * All crossings strictly within the band at other values, decimal texts in SI: `values` lists [element, key, text], `threshold` has numbers
   * of the JND by name. A threshold that is touched is none. `why` says why there is no answer: pi in the scene, a delay, too high a degree.
   */
  function crossings(text, name, catalogue, { values, threshold, band }) {
    try {
      const scene = reader(catalogue)(text, name);
      values.forEach(([place, key, told]) => {
        const x = typeof place === "number" ? scene.elements.effects[place] : scene.elements[place];
        const own = key.replace(/\[([0-9]+)\]$/, "_$1");
        const number = decimal(told);
        need(x && x.numbers.has(own), "a parameter is not one of a rational scene");
        x.numbers.set(own, quantityOf(number));
      });
      const { environment, rendered, effects } = scene.elements;
      const still = [environment, rendered, ...effects].every((x) => x.lags.every(([key]) => !x.numbers.get(key).value.n));
      need(still, "there is a delay, and this is for rational scenes");
      scene.region = withLimits(scene.region, threshold);
      const step = scene.region.shape === "square" && [...scene.region.limits.values()].every((x) => x.value) ? 2 : 1;
      const [low, high] = band.map((x) => decimal(x).power(step));
      need(low.compare(high) < 0, "the band is empty");
      const found = Object.entries(polynomialsOf(scene, step)).flatMap(([part, terms]) => signChanges(terms, low, high).map(({ cell, rising }) => ({ part, rising, omega: root(cell, step) })));
      return { crossings: found.sort((x, y) => x.omega - y.omega), why: "" };
    } catch (error) {
      if (error instanceof Refused || error instanceof RangeError) return { crossings: null, why: error.message };
      throw error;
    }
  }

  return { verdict, crossings, sha256, toml };
})();
if (typeof module !== "undefined") module.exports = haptisymCheck;
