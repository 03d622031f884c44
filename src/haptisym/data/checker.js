// Checks a certificate of a rational scene against the scene's file: written from docs/certificates.md, with nothing from elsewhere.
// After `scene.js`. The rules of the specification, one after the other; at the end what the explorer of a report asks for, crossings
// at other values, found by the rules that prove those of a certificate. All else is for `python -m haptisym_check`.
const haptisymCheck = (function () {
  "use strict";
  const {
    Refused, need, signOf, sum, bitsOf, wordsOf, MOST_WORDS, divisor, Fraction, ZERO, ONE, decimal, toml,
    UNIT, value, plus, times, conjugate, combined, PARTS, quantityOf, at, own, reader,
  } = typeof haptisymScene === "undefined" ? require("./scene.js") : haptisymScene;

  // Reading a certificate: nothing but what the specification knows.

  /** SHA-256 of a text in UTF-8 (FIPS 180-4); its constants are bits of the roots of primes, of which a double has enough. */
  function sha256(text) {
    const bytes = [...new TextEncoder().encode(text)];
    const length = 8 * bytes.length;
    bytes.push(0x80);
    while (bytes.length % 64 !== 56) bytes.push(0);
    for (let k = 7; k >= 0; k -= 1) bytes.push(Math.floor(length / 256 ** k) % 256);
    const primes = [];
    for (let n = 2; primes.length < 64; n += 1) if (primes.every((p) => n % p)) primes.push(n);
    const bits = (x) => ((x % 1) * 2 ** 32) | 0;
    const rounds = primes.map((p) => bits(Math.cbrt(p)));
    const state = primes.slice(0, 8).map((p) => bits(Math.sqrt(p)));
    const turned = (x, ...n) => n.reduce((y, k) => y ^ ((x >>> k) | (x << (32 - k))), 0);
    for (let at = 0; at < bytes.length; at += 64) {
      const w = Array.from({ length: 16 }, (_, i) => bytes.slice(at + 4 * i, at + 4 * i + 4).reduce((x, b) => (x << 8) | b, 0));
      for (let i = 16; i < 64; i += 1) w.push((w[i - 16] + (turned(w[i - 15], 7, 18) ^ (w[i - 15] >>> 3)) + w[i - 7] + (turned(w[i - 2], 17, 19) ^ (w[i - 2] >>> 10))) | 0);
      let [a, b, c, d, e, f, g, h] = state;
      for (let i = 0; i < 64; i += 1) {
        const one = (h + turned(e, 6, 11, 25) + ((e & f) ^ (~e & g)) + rounds[i] + w[i]) | 0;
        const two = (turned(a, 2, 13, 22) + ((a & b) ^ (a & c) ^ (b & c))) | 0;
        [h, g, f, e, d, c, b, a] = [g, f, e, (d + one) | 0, c, b, a, (one + two) | 0];
      }
      [a, b, c, d, e, f, g, h].forEach((x, i) => { state[i] = (state[i] + x) | 0; });
    }
    return state.map((x) => (x >>> 0).toString(16).padStart(8, "0")).join("");
  }

  const isObject = (x) => x && typeof x === "object" && !Array.isArray(x);

  function keyed(x, ...keys) {
    const found = isObject(x) ? Object.keys(x) : null;
    need(found && found.length === keys.length && keys.every((key) => found.includes(key)), `expected an object with the keys ${keys.join(", ")}`);
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

  /** Where a chain is computed: s, a ratio, and a whole number in place of pi. */
  const along = (x, pi) => ({ s: [value(x, 0n, [1, 0]), UNIT], pi });
  const onAxis = (x, pi) => ({ s: [value(0n, x, [1, 0]), UNIT], pi });

  const CURVES = ["environment", "perceived", "excess", "difference", "sum"];
  const NAMES = CURVES.flatMap((x) => PARTS.map((part) => `${x}.${part}`));

  function product(x, factors) {
    const [told, rows] = keyed(x, "number", "powers");
    const number_ = number(told);
    const pairs = listed(rows, 500).map((row) => listed(row, 2, 2));
    const powers = new Map(pairs.map(([i, n]) => [whole(i, 0, factors.length - 1), whole(n, -100, 100)]));
    need(powers.size === pairs.length, "a factor stands twice in a product");
    need(number_.n || !pairs.length, "a function that is zero everywhere has no factors");
    return { number: number_, powers, words: [...powers].reduce((n, [i, k]) => n + Math.abs(k) * factors[i].words, 0) };
  }

  /** Numerator and denominator, with values of the factors. */
  function sides(p, values) {
    const found = [p.number.n, p.number.d];
    p.powers.forEach((n, i) => {
      const place = n < 0 ? 1 : 0;
      need(wordsOf(values[i]) * Math.abs(n) + wordsOf(found[place]) < MOST_WORDS, "a number is too large");
      found[place] *= values[i] ** BigInt(Math.abs(n));
    });
    return found;
  }

  /** Their degrees in omega (or s), or in pi. */
  function degreesOf(p, variable, factors) {
    const found = [0, 0];
    p.powers.forEach((n, i) => { found[n < 0 ? 1 : 0] += factors[i].degrees[variable] * Math.abs(n); });
    return found;
  }

  /** The ten functions of a scene, numerator and denominator. */
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
    PARTS.forEach((part, i) => {
      const [[x], limit] = [found[`difference.${part}`], at(scene.threshold[i], where.pi)];
      found[`excess.${part}`] = combined("-", [times(x, x), times(root, conjugate(root))], combined("*", limit, limit));
    });
    return found;
  }

  /**
   * Refused unless the products are the functions of a scene at (x, pi): on a grid that decides it. `length` is that of the scene's
   * formulas; of `share` such questions none may take longer than so much of what one may.
   */
  function link(told, factors, scene, length, share = 1) {
    const every = Object.keys(told);
    const work = [...factors, ...Object.values(told)].reduce((n, x) => n + x.words, 5 * length + 100);

    /** Numerator and denominator of functions, of the scene and as told. */
    function sidesAt(names, x, pi) {
      const [values, found] = [factors.map((f) => f.at(x, pi)), scene(x, pi)];
      return names.map((name) => [name, ...found[name], ...sides(told[name], values)]);
    }

    /** Those of some functions of which what is to be zero is zero on a grid; `bound`: of its degree, of the degrees of the four sides. */
    function proven(names, bound, isZero) {
      const most = new Map(names.map((name) => [name, [0, 1].map((i) => bound(...first[name].map((x) => x.degrees[i]), ...degreesOf(told[name], i, factors)))]));
      const [n, m] = [0, 1].map((i) => Math.max(0, ...[...most.values()].map((x) => x[i])) + 1);
      need(n <= 3000 && n * m * work * share <= 3e7, "the degrees are too high");
      const left = new Set(names);
      for (let k = 0; k < n * m; k += 1) {
        const [x, pi] = [Math.floor(k / m), k % m];
        const asked = names.filter((name) => left.has(name) && x <= most.get(name)[0] && pi <= most.get(name)[1]);
        (asked.length ? sidesAt(asked, BigInt(x), BigInt(pi + 1)) : []).forEach(([name, top, bottom, above, below]) => {
          need(above * bottom.re === below * top.re && above * bottom.im === below * top.im, `${name} is not that of the scene`);
          if (!isZero(name, top, bottom, above, below)) left.delete(name);
        });
      }
      return left;
    }

    const first = scene(0n, 1n);
    const fixed = new Map();
    for (let k = 17n; k < 25n && fixed.size < every.length; k += 1n) {
      sidesAt(every, k, k + 1n).forEach(([name, , bottom, , right]) => {
        if ((bottom.re || bottom.im) && right) fixed.set(name, [right, bottom]);
      });
    }
    need(fixed.size === every.length, "a function is nowhere defined");
    const alike = proven(every, Math.max, (name, top, bottom, left, right) => { // mostly they are so, but for one number
      const [u, v] = fixed.get(name);
      return [[top, left], [bottom, right]].every(([x, y]) => x.re * u === y * v.re && x.im * u === y * v.im);
    });
    proven(every.filter((name) => !alike.has(name)), (top, bottom, left, right) => Math.max(left + bottom, right + top), () => true);
  }

  // Rules 2 and 3: zeros and signs of polynomials, and the chart.

  const SCALE = 10n ** 100n;

  /** Whole numbers below and above pi 10^100: pi/4 = 4 arctan 1/5 - arctan 1/239 (Machin), by alternating series. */
  const PI = (function () {
    const arctangent = (n, terms) => Array.from({ length: terms }, (_, k) => new Fraction(k % 2 ? -1n : 1n, BigInt(2 * k + 1) * n ** BigInt(2 * k + 1))).reduce((x, y) => x.plus(y));
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

  /** A polynomial in x^step: `signs` of the coefficients that rule 2 has in a cell, the first ones 0 left out, and the order at its low end. */
  function factor(step, rows) {
    const [m, both] = [Math.max(...rows.map((row) => row.length)), bounds(rows)];
    return {
      step,
      rows,
      degrees: [step * (rows.length - 1), m - 1],
      words: rows.flat().reduce((n, c) => n + 1 + Math.floor(bitsOf(c) / 64), 10),
      cost: rows.length ** 3 * m + 1000,
      at: (x, pi) => rows.reduceRight((y, row) => y * x ** BigInt(step) + row.reduceRight((z, c) => z * pi + c, 0n), 0n),
      sign: (x) => sign(both, x.power(step)),
      signs(a, b) {
        const found = agreed(both.map((p) => moved(p, a.power(step), b.power(step))));
        const n = leading(found);
        return [a.n ? n : step * n, found.slice(n)]; // at 0 the order is one in omega
      },
    };
  }

  function factorOf(x) {
    const [step, p] = keyed(x, "step", "polynomial");
    return factor(whole(step, 1, 2), polynomial(p));
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
    const [[low, lowTop], [high, highTop]] = endsOf(scene);
    const last = points.length - 1;
    const ascend = (...list) => list.every((x, i) => !i || list[i - 1].compare(x) <= 0);
    need(ascend(ZERO, points[0], low) && ascend(lowTop, points[1]), "the first cell does not hold the low end of the band");
    need(ascend(points[last - 1], high) && ascend(highTop, points[last]), "the last cell does not hold the high end of the band");
    affordable(points, factors.reduce((n, { cost }) => n + cost, 0));
    affordable(told.flat(), Math.floor(Math.max(0, ...factors.map(({ cost }) => cost)) / 10));
    const chart = { from0: lowTop.n === 0n, orders: [new Map()], signs: [] };
    const trailing = new Map();
    let used = 1;
    need(told.length > 1 && ascend(told[0][0], low) && ascend(lowTop, told[0][1]), "the low end of the band is not in its enclosure");
    for (let k = 0; k < last; k += 1) {
      const [a, b] = [points[k], points[k + 1]];
      const starts = low.compare(a) === 0 && lowTop.compare(a) === 0;
      const stops = high.compare(b) === 0 && highTop.compare(b) === 0;
      const inner = factors.map((f, i) => {
        const [lead, signs] = f.signs(a, b);
        const trail = leading([...signs].reverse());
        need((starts || !lead) && (stops || !trail), "a factor is zero at a breakpoint");
        if (lead) chart.orders[0].set(i, lead);
        if (trail) trailing.set(i, trail);
        return signs.filter((x) => x);
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
        chart.orders.push(new Map([[i, 1]]));
        chart.signs.push(inner.map((s) => s[s.length - 1]));
      }
    }
    chart.orders.push(trailing);
    need(used === told.length - 1, "there are not as many frequencies as places");
    need(ascend(told[used][0], high) && ascend(highTop, told[used][1]), "the high end of the band is not in its enclosure");
    return chart;
  }

  // Rule 4: what follows.

  function curve(p, chart) {
    const order = chart.orders.map((found) => [...p.powers].reduce((x, [f, n]) => x + (found.get(f) || 0) * n, 0));
    const between = chart.signs.map((row) => [...p.powers].reduce((x, [f, n]) => x * (n % 2 ? row[f] : 1), signOf(p.number.n)));
    const flip = (x, n) => (n % 2 ? -x : x) || 0;
    const before = [flip(between[0], order[0]), ...between];
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
    const excess = PARTS.map((part) => curves[`excess.${part}`]);
    const crossings = places.flatMap((i) => PARTS.flatMap((part, k) => {
      const c = excess[k];
      if (c.order[i] <= 0) return [];
      const touches = c.before[i] === c.after[i] && !(i === 0 && from0 && c.after[i] > 0);
      const kind = touches ? "touches" : c.after[i] > 0 ? "exceeds" : "returns";
      return [{ at: i, part, kind, sign: curves[`difference.${part}`].after[i], multiplicity: c.order[i] }];
    }));
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

  function evaluation(claim, proof, scene) {
    const [lags, powers, points, told, products, poles] = keyed(proof, "delays", "orders", "breakpoints", "factors", "functions", "poles");
    [lags, powers].forEach((x) => listed(x, 0)); // it is that of a rational scene
    const factors = listed(told, 500).map(factorOf);
    const written = Object.fromEntries(keyed(products, ...NAMES).map((x, i) => [NAMES[i], product(x, factors)]));
    link(written, factors, (x, pi) => functions(scene, onAxis(x, pi)), scene.length);
    const enclosures = listed(claim.frequencies, 2000, 2).map((pair) => listed(pair, 2, 2).map(number));
    const chart = charted(scene, ascending(points, 2000, 2), factors, enclosures);
    const curves = Object.fromEntries(NAMES.map((name) => [name, curve(written[name], chart)]));
    const count = poles === null ? null : zeros(poles, poleOf(scene), scene.length);
    return { frequencies: claim.frequencies, ...claimed(curves, chart.from0), stable: count === null ? null : count === 0 };
  }

  // Rule 5: zeros in Re s >= 0.

  const PRIME = 2n ** 61n - 1n;
  const residue = (n) => ((n % PRIME) + PRIME) % PRIME;

  /** 1/x modulo the prime (Fermat). */
  function inverse(x) {
    let [found, power] = [1n, x];
    for (let left = PRIME - 2n; left; left >>= 1n) {
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
    const [told, products, cells] = keyed(x, "factors", "function", "cells");
    const factors = listed(told, 100).map(polynomial);
    const linked = factors.map((rows) => factor(1, rows));
    const p = product(products, linked);
    link({ it: p }, linked, (s, pi) => ({ it: ratio(along(s, pi)) }), length, share);
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

  const poleOf = (scene) => (where) => [...scene.at(where)[1]].reverse();

  function stability(claim, proof, scene) {
    const [poles, held] = keyed(proof, "imposed", "held");
    const told = listed(claim.held, 100);
    const proofs = listed(held, told.length, told.length);
    const asked = [scene.length, 1 + told.length];
    const count = zeros(poles, poleOf(scene), ...asked);
    const found = told.map((row, i) => {
      const [hand] = keyed(row, "hand", "unstable");
      const z = scene.hand(hand, typeof hand === "string" ? null : keyed(hand, "m", "b", "k").map(number));
      return { hand, unstable: zeros(proofs[i], (where) => combined("+", scene.at(where)[1], z(where)), ...asked) };
    });
    return { imposed: count, held: found };
  }

  // Rule 6: for which values of a free parameter a display is transparent.

  /** Polynomials in omega^step whose sum, with positive weights, a factor is for every value between two. */
  function slicesOf(f, low, high) {
    const bits = [low.n, low.d, high.n, high.d].reduce((n, x) => n + bitsOf(x), 0);
    need(bits * (f.degrees[1] + 1) < 1e5, "the ends of a slab are too long");
    const rows = f.rows.map((row) => moved([...row, ...Array(f.degrees[1] + 1 - row.length).fill(0n)], low, high));
    const slices = rows[0].map((_, i) => rows.map((row) => row[i]));

    /** The sign from a to b, for all values between those two; `closed`: for which of these it must have it as well. */
    return (a, b, closed) => {
      const signs = slices.map((row) => moved(row, a.power(f.step), b.power(f.step)).map(signOf).filter((x) => x));
      const found = new Set(signs.flat());
      need(found.size === 1, "a sign is not proven");
      need((signs[0].length || !closed[0]) && (signs[signs.length - 1].length || !closed[1]), "a factor may be zero");
      return [...found][0];
    };
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
      at.slice(1).forEach((b, i) => need(Object.values(told).every((x) => sign(x, at[i], b, false) <= 0), "an excess may be positive"));
      return;
    }
    const x = PARTS.includes(part) && told[`excess.${part}`];
    need(x && at.length === 1 && at[0].compare(band[0][1]) >= 0 && at[0].compare(band[1][0]) <= 0, "a point is not on the band");
    need(sign(x, at[0], at[0], true) > 0, "an excess may not be positive");
  }

  /** Intervals of values, ascending, each with whether the display is transparent for them; and which parts bind between them. */
  function valuesOf(told, factors, slabs, scene) {
    const rows = listed(slabs, 500, 1).map((x) => keyed(x, "from", "to", "points", "part"));
    const triples = rows.flatMap(([low, high, points]) => listed(points, 500, 1).map((x) => [low, high, x]));
    const cost = factors.reduce((n, f) => n + 2 * (f.rows.length * (f.degrees[1] + 1)) ** 2 + 2000, 0);
    affordable(triples.flat().filter((x) => x !== null).map(number), cost);
    const joined = (i) => i > 0 && i < rows.length && rows[i - 1][1] === rows[i][0] && (rows[i - 1][3] === null) === (rows[i][3] === null);
    const point = (x, infinity) => (x === null ? { n: infinity, d: 0n } : number(x));
    const isLess = (x, y) => x.n * y.d < y.n * x.d;
    const band = endsOf(scene);
    const binds = [];
    const values = rows.reduce((found, [low, high, points, part], i) => {
      const [start, end, last] = [point(low, -1n), point(high, 1n), found[found.length - 1]];
      need(isLess(start, end) && !(last && (low === null || isLess(start, point(last[1], 1n)))), "the slabs do not ascend");
      need(joined(i) || !last || last[2] !== (part === null), "between two slabs there is more than an end");
      verify(told, factors.map((f) => slicesOf(f, start, end)), [joined(i), joined(i + 1)], points, part, band);
      if (last && !joined(i)) binds.push(part === null ? rows[i - 1][3] : part);
      return joined(i) ? [...found.slice(0, -1), [last[0], high, part === null]] : [...found, [low, high, part === null]];
    }, []);
    return { values, binds };
  }

  function requirement(claim, proof, scene) {
    const whole = isObject(proof) ? { delays: [], orders: [], ...proof } : proof;
    const [lags, powers, every, products, slabs] = keyed(whole, "delays", "orders", "factors", "functions", "slabs");
    [lags, powers].forEach((x) => listed(x, 0)); // it is that of a rational scene
    const parts = PARTS.filter((part) => listed(claim.parts, 2, 1).includes(part));
    const names = parts.map((part) => `excess.${part}`);
    const factors = listed(every, 500).map(factorOf);
    const told = Object.fromEntries(keyed(products, ...names).map((x, i) => [names[i], product(x, factors)]));
    link(told, factors, (x, pi) => functions(scene, onAxis(x, pi)), scene.length);
    return { free: listed(claim.free, 9, 1), parts, ...valuesOf(told, factors, slabs, scene) };
  }

  // The questions that a certificate may answer, each with what follows from its proof.

  const QUESTIONS = { evaluation, stability, requirement };

  const sorted = (x) => JSON.stringify(x, (_, y) => (isObject(y) ? Object.fromEntries(Object.entries(y).sort()) : y));

  /** The claim, if the certificate proves it for that scene; a Refused error, and why, if not. */
  function check(text, sceneText, catalogue) {
    const [kind, digest, name, claim, proof] = keyed(json(text), "format", "scene_sha256", "environment", "claim", "proof");
    need(kind === "haptisym.certificate/1", "the format is not haptisym.certificate/1");
    need(new TextEncoder().encode(sceneText).length <= 1e6, "the scene is too large");
    need(digest === sha256(sceneText), "the certificate is that of another scene file");
    need(name === null || typeof name === "string", "the environment has no name");
    need(isObject(claim) && own(QUESTIONS, claim.question), "the claim answers no question that is known");
    const follows = QUESTIONS[claim.question](claim, proof, reader(catalogue)(sceneText, name, "free" in claim ? listed(claim.free, 9, 1) : null));
    keyed(claim, "question", ...Object.keys(follows));
    Object.entries(follows).forEach(([key, x]) => need(sorted(claim[key]) === sorted(x), `${key}: something else is proven than what is claimed`));
    return claim;
  }

  /** What is found, or null and why not. */
  function said(name, find) {
    try {
      return { [name]: find(), why: "" };
    } catch (error) {
      if (error instanceof Refused || error instanceof RangeError) return { [name]: null, why: error.message };
      throw error;
    }
  }

  /** The claim, with words instead of errors: it is null where it is not proven. */
  const verdict = (text, sceneText, catalogue) => said("claim", () => check(text, sceneText, catalogue));

  // Crossings at other values of a scene's parameters, for the explorer.

  function primitive(p) {
    const [by, length] = [p.reduce(divisor, 0n), p.length - [...p].reverse().findIndex((c) => c)];
    return by ? p.slice(0, length).map((c) => c / by) : [];
  }

  /** Quotient and remainder of a by b, each times a number. */
  function divided(a, b) {
    let [whole, rest] = [[], a];
    while (rest.length >= b.length) {
      const [top, lead, shift] = [rest[rest.length - 1], b[b.length - 1], rest.length - b.length];
      whole = [top, ...whole.map((c) => c * lead)];
      rest = rest.map((c, i) => c * lead - (i >= shift ? top * b[i - shift] : 0n)).slice(0, -1);
    }
    return [primitive(whole), primitive(rest)];
  }

  /** A polynomial with the same zeros, each simple: p over what it has in common with its derivative (Euclid). */
  function simple(p) {
    let [x, y] = [p, p.slice(1).map((c, i) => c * BigInt(i + 1))];
    if (y.length && coprime(...[x, y].map((q) => q.map((c) => [c])))) return p;
    while (y.length) [x, y] = [y, divided(x, y)[1]];
    return divided(p, x)[0];
  }

  /** About the middle, where p is not zero. */
  function cut(p, a, b) {
    let middle = a.plus(b).over(new Fraction(2n));
    for (let n = 3n; sign([p], middle) === 0; n += 1n) middle = a.plus(b.minus(a).over(new Fraction(n)));
    return middle;
  }

  const nonzero = (p, a, b) => moved(p, a, b).map(signOf).filter((x) => x);

  /** Narrow intervals that hold one zero each, of a polynomial with simple zeros; all of those strictly between a and b (Vincent). */
  function isolated(p, a, b) {
    const signs = nonzero(p, a, b);
    const turns = changes(signs);
    if (turns === 0 || (turns === 1 && b.minus(a).times(new Fraction(10n ** 9n)).compare(b) <= 0)) return turns ? [[a, b]] : [];
    const middle = cut(p, a, b);
    if (turns === 1) return sign([p], middle) === signs[0] ? isolated(p, middle, b) : isolated(p, a, middle);
    return [...isolated(p, a, middle), ...isolated(p, middle, b)];
  }

  /** A polynomial of a degree in omega^2 with whole coefficients, but for a positive number: by its values at omega = 0, 1, ... (Newton). */
  function interpolated(values) {
    const nodes = values.map((_, k) => new Fraction(BigInt(k * k)));
    let [found, basis, column] = [[], [ONE], values];
    nodes.forEach((node, n) => {
      found = basis.map((c, i) => (found[i] || ZERO).plus(c.times(column[0])));
      basis = [ZERO, ...basis].map((c, i) => c.minus((basis[i] || ZERO).times(node)));
      column = column.slice(1).map((y, i) => y.minus(column[i]).over(nodes[i + n + 1].minus(nodes[i])));
    });
    const scale = found.reduce((x, c) => (x * c.d) / divisor(x, c.d), 1n);
    return primitive(found.map((c) => (c.n * scale) / c.d));
  }

  /**
   * All crossings strictly within the band at other values, decimal texts in SI: `values` lists [element, key, text], `threshold` has
   * that of each part. A threshold that is touched is none. `why` says why there is no answer: pi in the scene, a delay, too high a degree.
   */
  function crossings(text, name, catalogue, { values, threshold, band }) {
    return said("crossings", () => {
      const scene = reader(catalogue)(text, name);
      values.forEach(([place, key, told]) => {
        const x = typeof place === "number" ? scene.elements.effects[place] : scene.elements[place];
        const own = key.replace(/\[([0-9]+)\]$/, "_$1");
        need(x && x.numbers.has(own), "a parameter is not one of a rational scene");
        x.numbers.set(own, quantityOf(decimal(told)));
      });
      PARTS.forEach((part, i) => { if (part in threshold) scene.threshold[i] = quantityOf(decimal(threshold[part])); });
      const [low, high] = band.map((x) => decimal(x).power(2));
      need(low.compare(high) < 0, "the band is empty");
      const [first, known] = [functions(scene, onAxis(0n, 1n)), []];
      const found = PARTS.flatMap((part) => {
        const [degree, degreeInPi] = first[`excess.${part}`][0].degrees; // what stands below is a square
        need(degreeInPi <= 0, "pi is among the numbers");
        need(degree <= 40, "the degrees are too high for that");
        for (let k = known.length; 2 * k <= Math.max(0, degree); k += 1) known.push(functions(scene, onAxis(BigInt(k), 1n)));
        const p = interpolated(known.slice(0, 1 + Math.max(0, Math.floor(degree / 2))).map((x) => new Fraction(x[`excess.${part}`][0].re)));
        return (p.length ? isolated(simple(p), low, high) : []).map(([a, b]) => {
          const [signs, middle] = [nonzero(p, a, b), a.plus(b)];
          return { part, was: signs[0], is: signs[signs.length - 1], omega: Math.sqrt(Number((middle.n * 10n ** 30n) / (middle.d * 2n)) / 1e30) };
        });
      });
      return found.filter(({ was, is }) => was !== is).map(({ part, is, omega }) => ({ part, rising: is > 0, omega })).sort((x, y) => x.omega - y.omega);
    });
  }

  return { verdict, crossings, sha256, toml };
})();
if (typeof module !== "undefined") module.exports = haptisymCheck;
