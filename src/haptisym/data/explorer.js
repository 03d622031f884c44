// The explorer of a report: sliders for the scene's parameters, and the closed forms drawn anew as they move.
// It needs `distortion`, the function generated from the scene, and what the element "explorer-data" says of the sliders.
(function () {
  "use strict";
  const SVG = "http://www.w3.org/2000/svg";
  const SIZE = { width: 480, height: 300, left: 52, right: 12, top: 12, bottom: 40 };
  const PARTS = ["real", "imag"];
  const spec = JSON.parse(document.getElementById("explorer-data").textContent);
  const [low, high] = spec.band;
  const initial = new Map(spec.sliders.map((slider) => [slider.id, slider.value]));
  const values = new Map(initial);
  const find = (id) => document.getElementById(id);

  // The closed forms.

  /** The values of the closed forms at omega with the sliders' (or other) values. */
  function at(omega, chosen) {
    return distortion(omega, ...spec.arguments.map((id) => chosen.get(id)));
  }

  const fields = (v) => [v.ratio_real, v.ratio_imag, v.environment_real, v.environment_imag, v.perceived_real, v.perceived_imag];

  function evenly(count, chosen) {
    const grid = Array.from({ length: count + 1 }, (_, i) => (i === count ? high : low + (i * (high - low)) / count));
    return grid.map((omega) => ({ omega, v: at(omega, chosen) }));
  }

  /** The samples, with others between two wherever a straight line strays from what is seen of the curves. */
  function refined(samples, seen, chosen) {
    const found = [samples[0]];
    function between(a, b, depth) {
      const omega = (a.omega + b.omega) / 2;
      const middle = { omega, v: at(omega, chosen) };
      const [p, q, m] = [a, b, middle].map(seen);
      const bent = m.some((x, i) => Math.abs(x - (p[i] + q[i]) / 2) > 1e-3);
      if (bent && depth > 0) {
        between(a, middle, depth - 1);
        between(middle, b, depth - 1);
      } else {
        found.push(b);
      }
    }
    samples.slice(1).forEach((b, i) => between(samples[i], b, 9));
    return found;
  }

  const threshold = (part) => values.get(spec.thresholds[part]);
  const exceeds = (part, v) => !(v[`ratio_${part}`] <= threshold(part));

  /** Where a ratio meets its threshold between samples, by bisection. */
  function crossings(samples, part) {
    const found = [];
    for (let i = 1; i < samples.length; i += 1) {
      const rising = exceeds(part, samples[i].v);
      if (rising !== exceeds(part, samples[i - 1].v)) {
        let [a, b] = [samples[i - 1].omega, samples[i].omega];
        for (let n = 0; n < 60; n += 1) {
          const middle = (a + b) / 2;
          if (exceeds(part, at(middle, values)) === rising) b = middle;
          else a = middle;
        }
        found.push({ part, omega: b, rising });
      }
    }
    return found;
  }

  /** The intervals on which neither ratio exceeds its threshold. */
  function transparent(edges) {
    const ends = [low, ...edges.map((x) => x.omega), high];
    const found = [];
    for (let i = 1; i < ends.length; i += 1) {
      const v = at((ends[i - 1] + ends[i]) / 2, values);
      if (ends[i] > ends[i - 1] && !PARTS.some((part) => exceeds(part, v))) {
        if (found.length && found[found.length - 1][1] === ends[i - 1]) found[found.length - 1][1] = ends[i];
        else found.push([ends[i - 1], ends[i]]);
      }
    }
    return found;
  }

  // What of the plane is shown.

  function quantile(sorted, share) {
    return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
  }

  /** The upper end of the ratios' axis: the highest value, unless that is a narrow peak. */
  function ratioTop(samples) {
    const least = 2 * Math.max(...PARTS.map(threshold));
    const upper = samples.map((x) => Math.max(x.v.ratio_real, x.v.ratio_imag)).filter(Number.isFinite).sort((a, b) => a - b);
    if (!upper.length) return least;
    const highest = upper[upper.length - 1];
    const common = highest <= 3 * quantile(upper, 0.9) ? 1.06 * highest : 2.5 * quantile(upper, 0.75);
    return Math.max(common, least);
  }

  /** Low and high end of an axis of H: all values, but for excursions far from most of them. */
  function extent(numbers) {
    const sorted = numbers.filter(Number.isFinite).sort((a, b) => a - b);
    if (!sorted.length) return [-1, 1];
    const [first, last] = [quantile(sorted, 0.03), quantile(sorted, 0.97)];
    const span = last - first;
    const [least, most] = [sorted[0], sorted[sorted.length - 1]];
    return [least < first - 3 * span ? first - span : least, most > last + 3 * span ? last + span : most];
  }

  /** The window of the Nyquist plot, at equal scales unless one axis would be very short. */
  function window_(samples) {
    const x = extent(samples.flatMap((p) => [p.v.environment_real, p.v.perceived_real]));
    const y = extent(samples.flatMap((p) => [p.v.environment_imag, p.v.perceived_imag]));
    const room = [SIZE.width - SIZE.left - SIZE.right, SIZE.height - SIZE.top - SIZE.bottom];
    const sizes = [x[1] - x[0], y[1] - y[0]];
    const scale = Math.max(sizes[0] / room[0], sizes[1] / room[1]) || 1;
    const equal = sizes.every((size, i) => size > 0.15 * scale * room[i]);
    return [x, y].map(([a, b], i) => {
      const half = 0.56 * (equal ? scale * room[i] : sizes[i] || 0.1 * (sizes[1 - i] || Math.abs(a) || 1));
      return [(a + b) / 2 - half, (a + b) / 2 + half];
    });
  }

  // Drawing.

  function shape(parent, name, attributes, text) {
    const made = document.createElementNS(SVG, name);
    Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  }

  /** A fresh drawing: `place` turns data into its coordinates, `data` is a group whose coordinates are the data. */
  function plot(svg, [x0, x1], [y0, y1]) {
    [...svg.children].slice(1).forEach((child) => child.remove()); // its title stays
    const [width, height] = [SIZE.width - SIZE.left - SIZE.right, SIZE.height - SIZE.top - SIZE.bottom];
    const [sx, sy] = [width / (x1 - x0), height / (y1 - y0)];
    const place = (x, y) => [SIZE.left + (x - x0) * sx, SIZE.top + (y1 - y) * sy];
    const clip = `${svg.id}-clip`;
    shape(shape(shape(svg, "defs", {}), "clipPath", { id: clip }), "rect", { x: SIZE.left, y: SIZE.top, width, height });
    const inside = shape(svg, "g", { "clip-path": `url(#${clip})` });
    const data = shape(inside, "g", { transform: `matrix(${sx} 0 0 ${-sy} ${SIZE.left - x0 * sx} ${SIZE.top + y1 * sy})` });
    return { svg, inside, data, place, x: [x0, x1], y: [y0, y1] };
  }

  function ticks([a, b], count) {
    const rough = (b - a) / count;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= rough);
    const first = Math.ceil(a / step - 1e-9);
    return Array.from({ length: Math.floor(b / step + 1e-9) - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
  }

  const written = (x) => String(x).replace("-", "−").replace(/e\+?/, "·10^");

  /** A text in which what follows a low line is a subscript. */
  function label(parent, attributes, text) {
    const made = shape(parent, "text", { class: "name", ...attributes });
    text.split(/_([a-z]+)/).forEach((piece, i) => {
      shape(made, "tspan", i % 2 ? { dy: 3, "font-size": "75%" } : { dy: i ? -3 : 0 }, piece);
    });
  }

  function axes(chart, xName, yName, unit) {
    const [left, bottom] = [SIZE.left, SIZE.height - SIZE.bottom];
    const prefix = (range) => (unit && Math.max(...range.map(Math.abs)) >= 1e5 ? [1e3, "k"] : [1, ""]);
    const [[xFactor, xPrefix], [yFactor, yPrefix]] = [prefix(chart.x), prefix(chart.y)];
    ticks(chart.x, 6).forEach((x) => {
      const [px] = chart.place(x, 0);
      shape(chart.svg, "line", { class: "axis", x1: px, x2: px, y1: bottom, y2: bottom + 4 });
      shape(chart.svg, "text", { x: px, y: bottom + 16, "text-anchor": "middle" }, written(x / xFactor));
    });
    ticks(chart.y, 5).forEach((y) => {
      const [, py] = chart.place(0, y);
      shape(chart.svg, "line", { class: "axis", x1: left - 4, x2: left, y1: py, y2: py });
      shape(chart.svg, "text", { x: left - 7, y: py + 4, "text-anchor": "end" }, written(y / yFactor));
    });
    shape(chart.svg, "path", { class: "axis", d: `M${left} ${SIZE.top}V${bottom}H${SIZE.width - SIZE.right}` });
    const named = (name, sign) => (unit ? `${name} (${sign}${unit})` : name);
    const middle = { x: (left + SIZE.width - SIZE.right) / 2, y: SIZE.height - 6, "text-anchor": "middle" };
    label(chart.svg, middle, named(xName, xPrefix));
    const turned = { transform: `translate(12 ${(SIZE.top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" };
    label(chart.svg, turned, named(yName, yPrefix));
  }

  /** A curve in data coordinates; it has a gap where it is not finite, and ends not far outside of the axes. */
  function curve(chart, look, points) {
    const bound = ([a, b], x) => Math.min(Math.max(x, a - 20 * (b - a)), b + 20 * (b - a));
    let [d, pen] = ["", "M"];
    points.forEach(([x, y]) => {
      const finite = Number.isFinite(x) && Number.isFinite(y);
      if (finite) d += `${pen}${bound(chart.x, x)} ${bound(chart.y, y)}`;
      pen = finite ? "L" : "M";
    });
    shape(chart.data, "path", { class: look, d });
  }

  function dot(chart, look, x, y) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    const [cx, cy] = chart.place(x, y);
    shape(chart.inside, "circle", { class: look, cx, cy, r: 4 });
  }

  function drawRatios(samples, base, edges, bands, top, probe) {
    const chart = plot(find("explorer-ratios"), [low, high], [0, top]);
    bands.forEach(([a, b]) => shape(chart.data, "rect", { class: "band", x: a, y: 0, width: b - a, height: top }));
    new Set(PARTS.map(threshold)).forEach((c) => curve(chart, "limit", [[low, c], [high, c]]));
    curve(chart, "cursor", [[probe.omega, 0], [probe.omega, top]]);
    PARTS.forEach((part) => {
      const points = (list) => list.map((x) => [x.omega, x.v[`ratio_${part}`]]);
      if (base) curve(chart, `ghost ${part}`, points(base));
      curve(chart, `ratio ${part}`, points(samples));
    });
    edges.forEach((x) => dot(chart, `crossing ${x.part}`, x.omega, threshold(x.part)));
    PARTS.forEach((part) => dot(chart, "probe", probe.omega, probe.v[`ratio_${part}`]));
    axes(chart, "ω (rad/s)", "ratio to |H_env|");
  }

  function drawNyquist(samples, base, range, probe) {
    const chart = plot(find("explorer-nyquist"), ...range);
    curve(chart, "limit", [[range[0][0], 0], [range[0][1], 0]]);
    curve(chart, "limit", [[0, range[1][0]], [0, range[1][1]]]);
    const systems = ["environment", "perceived"];
    const point = (system, x) => [x.v[`${system}_real`], x.v[`${system}_imag`]];
    systems.forEach((system) => {
      if (base) curve(chart, `ghost ${system}`, base.map((x) => point(system, x)));
      curve(chart, `system ${system}`, samples.map((x) => point(system, x)));
    });
    systems.forEach((system) => dot(chart, `probe ${system}`, ...point(system, probe)));
    axes(chart, "Re H", "Im H", spec.unit);
  }

  // What is said.

  const short = (x) => written(Number(x.toPrecision(4)));
  const percent = (c) => `${short(100 * c)} %`;

  /** The text of an element, in which what follows a low line is a subscript. */
  function write(id, text) {
    const made = text.split(/_([a-z]+)/).map((piece, i) => {
      const part = document.createElement(i % 2 ? "sub" : "span");
      part.textContent = piece;
      return part;
    });
    find(id).replaceChildren(...made);
  }

  function say(bands, edges) {
    const pieces = bands.map(([a, b]) => `${short(a)} to ${short(b)}`).join(", ");
    write("explorer-band", bands.length ? `Transparent at ${pieces} rad/s.` : "Transparent nowhere on the band.");
    const told = edges.map((x) => {
      const ratio = x.part === "real" ? "r_r" : "r_i";
      return `${ratio} ${x.rising ? "rises above" : "falls below"} ${percent(threshold(x.part))} at ${short(x.omega)}`;
    });
    const more = told.length > 6 ? `; and ${told.length - 6} more` : "";
    write("explorer-crossings", told.length ? `${told.slice(0, 6).join("; ")}${more}.` : "No ratio meets its threshold.");
  }

  function sayProbe({ omega, v }) {
    const H = (re, im) => (Number.isFinite(re) && Number.isFinite(im) ? `${short(re)} ${im < 0 ? "−" : "+"} ${short(Math.abs(im))} j` : "infinite");
    const rows = { H_env: H(v.environment_real, v.environment_imag), H_perc: H(v.perceived_real, v.perceived_imag) };
    const ratios = PARTS.map((part) => `${part === "real" ? "r_r" : "r_i"} = ${short(v[`ratio_${part}`])}`);
    const noticed = PARTS.filter((part) => exceeds(part, v)).map((part) => (part === "real" ? "real" : "imaginary"));
    const verdict = noticed.length ? `noticed in the ${noticed.join(" and the ")} part` : "not noticed";
    const systems = Object.entries(rows).map(([name, text]) => `${name} = ${text} ${spec.unit}`);
    write("explorer-probe", `At ${short(omega)} rad/s: ${[...systems, ...ratios].join(", ")}: ${verdict}.`);
  }

  // All anew.

  function seenIn(top, [x, y]) {
    const ranges = [[0, top], [0, top], x, y, x, y];
    const share = (value, [a, b]) => (Number.isNaN(value) ? 2 : Math.min(Math.max((value - a) / (b - a), -1), 2));
    return (sample) => fields(sample.v).map((value, i) => share(value, ranges[i]));
  }

  function draw() {
    const even = evenly(300, values);
    const [top, range] = [ratioTop(even), window_(even)];
    const samples = refined(even, seenIn(top, range), values);
    const moved = spec.arguments.some((id) => values.get(id) !== initial.get(id));
    const base = moved ? refined(evenly(300, initial), seenIn(top, range), initial) : null;
    const edges = PARTS.flatMap((part) => crossings(samples, part)).sort((a, b) => a.omega - b.omega);
    const bands = transparent(edges);
    const probe = { omega: values.get("explorer-omega"), v: at(values.get("explorer-omega"), values) };
    drawRatios(samples, base, edges, bands, top, probe);
    drawNyquist(samples, base, range, probe);
    say(bands, edges);
    sayProbe(probe);
  }

  // What is proven, a moment after the sliders rest: by exact arithmetic, for the decimals that the boxes show.

  let resting = 0;
  function prove() {
    const place = find("explorer-proven");
    if (!place) return;
    clearTimeout(resting);
    place.textContent = "";
    if (!document.querySelector("#explorer-panel [aria-invalid]")) resting = setTimeout(proveNow, 250);
  }

  function proveNow() {
    const read = (id) => JSON.parse(find(id).textContent);
    const shown = (id) => find(`${id}-value`).value;
    const given = {
      values: spec.paths.map(([id, place, key]) => [place, key, shown(id)]),
      threshold: Object.fromEntries(PARTS.map((part) => [part, shown(spec.thresholds[part])])),
      band: spec.band.map(String),
    };
    const name = JSON.parse(read("certificate")).environment;
    const { crossings: found, why } = haptisymCheck.crossings(read("certificate-scene"), name, read("certificate-catalogue"), given);
    if (!found) {
      write("explorer-proven", `Not proven at these values: ${why}.`);
      return;
    }
    const told = found.map((x) => `${x.part === "real" ? "r_r" : "r_i"} ${x.rising ? "rises above" : "falls below"} its threshold at ${written(Number(x.omega.toPrecision(6)))}`);
    const count = found.length === 0 ? "No crossing" : found.length === 1 ? "1 crossing" : `${found.length} crossings`;
    const list = told.length ? `: ${told.slice(0, 6).join("; ")}${told.length > 6 ? "; and others" : ""}` : "";
    write("explorer-proven", `Proven at the decimals shown, in exact arithmetic${list}. ${count} within the band, none missed; a threshold that is only touched is not counted.`);
  }

  let waiting = false;
  function redraw() {
    prove();
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      draw();
    });
  }

  // The sliders.

  const STEPS = 500; // to each side of the middle
  const fromPosition = (s, n) => Number((s.log ? s.low * (s.high / s.low) ** ((n + STEPS) / (2 * STEPS)) : s.low + ((s.high - s.low) * (n + STEPS)) / (2 * STEPS)).toPrecision(4));
  const toPosition = (s, x) => Math.round(2 * STEPS * (s.log ? Math.log(x / s.low) / Math.log(s.high / s.low) : (x - s.low) / (s.high - s.low)) - STEPS);
  const allowed = (s, x) => Number.isFinite(x) && (s.open ? x > s.least : x >= (s.least ?? -Infinity)) && x <= (s.most ?? Infinity);

  function show(s, { typing } = {}) {
    const [slider, box] = [find(s.id), find(`${s.id}-value`)];
    const value = values.get(s.id);
    slider.value = toPosition(s, value);
    slider.setAttribute("aria-valuetext", `${short(value)} ${s.unit}`);
    if (!typing) box.value = Number(value.toPrecision(6));
    box.removeAttribute("aria-invalid");
  }

  spec.sliders.forEach((s) => {
    const [slider, box] = [find(s.id), find(`${s.id}-value`)];
    slider.min = -STEPS;
    slider.max = STEPS;
    slider.addEventListener("input", () => {
      const middle = Number(slider.value) === toPosition(s, initial.get(s.id));
      values.set(s.id, middle ? initial.get(s.id) : fromPosition(s, Number(slider.value)));
      show(s);
      redraw();
    });
    box.addEventListener("input", () => {
      if (!allowed(s, box.valueAsNumber)) {
        box.setAttribute("aria-invalid", "true");
        prove();
        return;
      }
      values.set(s.id, box.valueAsNumber);
      show(s, { typing: true });
      redraw();
    });
    box.addEventListener("change", () => {
      show(s);
      prove();
    });
    show(s);
  });
  find("explorer-reset").addEventListener("click", () => {
    initial.forEach((value, id) => values.set(id, value));
    spec.sliders.forEach((s) => show(s));
    redraw();
  });
  find("explorer-panel").hidden = false;
  draw();
  prove();
})();
