// The explorer of a report: sliders for the scene's parameters, and the closed forms drawn anew as they move.
// It needs `distortion`, the function generated from the scene, `haptisymRegion`, and what the element "explorer-data" says of the sliders.
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
  const region = haptisymRegion(spec.region, values);
  const scenes = haptisymRegion(spec.region, initial); // the scene's own
  const CRITERIA = region.criteria;
  const shown = (omega) => omega / spec.frequency.size; // in the scene's unit of frequency

  // The closed forms.

  /** The values of the closed forms at omega with the sliders' (or other) values. */
  function at(omega, chosen) {
    return distortion(omega, ...spec.arguments.map((id) => chosen.get(id)));
  }

  const fields = (x) => {
    const { v } = x;
    const ratios = CRITERIA.map((name) => region.judged(name, v, x.omega));
    return [...ratios, v.environment_real, v.environment_imag, v.perceived_real, v.perceived_imag, ...region.change(v)];
  };

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

  const exceeds = (name, x) => !(region.judged(name, x.v, x.omega) <= region.most(name, x.v, x.omega));
  const there = (omega) => ({ omega, v: at(omega, values) });

  /** Where a ratio meets its threshold between samples, by bisection. */
  function crossings(samples, part) {
    const found = [];
    for (let i = 1; i < samples.length; i += 1) {
      const rising = exceeds(part, samples[i]);
      if (rising !== exceeds(part, samples[i - 1])) {
        let [a, b] = [samples[i - 1].omega, samples[i].omega];
        for (let n = 0; n < 60; n += 1) {
          const middle = (a + b) / 2;
          if (exceeds(part, there(middle)) === rising) b = middle;
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
      const middle = there((ends[i - 1] + ends[i]) / 2);
      if (ends[i] > ends[i - 1] && !CRITERIA.some((name) => exceeds(name, middle))) {
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
    const sorted = (seen) => samples.map((x) => Math.max(...CRITERIA.map((name) => seen(name, x.v, x.omega)))).filter(Number.isFinite).sort((a, b) => a - b);
    const [upper, limits] = [sorted(region.judged), sorted(region.most)];
    const least = limits.length ? 2 * Math.min(limits[limits.length - 1], 3 * quantile(limits, 0.5)) : 1;
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
    return framed(x, y, 0.15);
  }

  /** A window with room around, at equal scales unless one axis would be shorter than that share of the other. */
  function framed(x, y, share) {
    const room = [SIZE.width - SIZE.left - SIZE.right, SIZE.height - SIZE.top - SIZE.bottom];
    const sizes = [x[1] - x[0], y[1] - y[0]];
    const scale = Math.max(sizes[0] / room[0], sizes[1] / room[1]) || 1;
    const equal = sizes.every((size, i) => size > share * scale * room[i]);
    return [x, y].map(([a, b], i) => {
      const half = 0.56 * (equal ? scale * room[i] : sizes[i] || 0.1 * (sizes[1 - i] || Math.abs(a) || 1));
      return [(a + b) / 2 - half, (a + b) / 2 + half];
    });
  }

  /** That of the region: all of it at equal scales, with room for the way out of it. */
  function regionWindow(lines) {
    const points = lines.flat().concat([[0, 0]]);
    const reach = [0, 1].map((i) => 1.5 * Math.max(...points.map((p) => Math.abs(p[i]))) || 1);
    return framed([-reach[0], reach[0]], [-reach[1], reach[1]], 0);
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

  const written = (x) => (Math.abs(x) >= 1e6 ? x.toExponential() : String(x)).replaceAll("-", "−").replace(/e\+?/, "·10^");

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
    const chart = plot(find("explorer-ratios"), [low, high].map(shown), [0, top]);
    const seen = (own, name, list, what) => list.map((x) => [shown(x.omega), own[what](name, x.v, x.omega)]);
    bands.map((ends) => ends.map(shown)).forEach(([a, b]) => shape(chart.data, "rect", { class: "band", x: a, y: 0, width: b - a, height: top }));
    const limits = CRITERIA.map((name) => seen(region, name, samples, "most"));
    const same = limits.length > 1 && limits[0].every(([, c], i) => c === limits[1][i][1]);
    limits.slice(same ? 1 : 0).forEach((points, i) => curve(chart, `limit ${same ? "" : CRITERIA[i]}`, points));
    curve(chart, "cursor", [[shown(probe.omega), 0], [shown(probe.omega), top]]);
    CRITERIA.forEach((name) => {
      if (base) curve(chart, `ghost ${name}`, seen(scenes, name, base, "judged"));
      curve(chart, `ratio ${name}`, seen(region, name, samples, "judged"));
    });
    edges.forEach((x) => dot(chart, `crossing ${x.part}`, shown(x.omega), region.judged(x.part, at(x.omega, values), x.omega)));
    CRITERIA.forEach((name) => dot(chart, "probe", shown(probe.omega), region.judged(name, probe.v, probe.omega)));
    axes(chart, `${spec.frequency.size === 1 ? "ω" : "f"} (${spec.frequency.unit})`, CRITERIA.length > 1 ? "ratio to |H_env|" : `enlargement of the ${spec.region.shape}`);
  }

  /** The region at the probe's frequency, and the way of the distortion through its plane. */
  function drawRegion(samples, base, lines, edges, probe) {
    const chart = plot(find("explorer-region"), ...regionWindow(lines));
    lines.forEach((points) => shape(chart.data, "path", { class: "region", d: `M${points.map((p) => p.join(" ")).join("L")}Z` }));
    curve(chart, "limit", [[chart.x[0], 0], [chart.x[1], 0]]);
    curve(chart, "limit", [[0, chart.y[0]], [0, chart.y[1]]]);
    if (base) curve(chart, "ghost change", base.map((x) => region.change(x.v)));
    curve(chart, "change", samples.map((x) => region.change(x.v)));
    edges.forEach((x) => dot(chart, `crossing ${x.part}`, ...region.change(at(x.omega, values))));
    dot(chart, "probe", ...region.change(probe.v));
    axes(chart, "Re ΔH/|H_env|", "Im ΔH/|H_env|");
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
  const often = (omega) => short(shown(omega));
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

  /** What happens at a crossing. */
  function meets(x) {
    if (x.part === "joint") return `ΔH ${x.rising ? "leaves" : "returns into"} the ${spec.region.shape}`;
    return `${x.part === "real" ? "r_r" : "r_i"} ${x.rising ? "exceeds" : "returns below"}`;
  }

  function say(bands, edges) {
    const pieces = bands.map(([a, b]) => `${often(a)} to ${often(b)}`).join(", ");
    write("explorer-band", `The sliders' values, computed: transparent ${bands.length ? `at ${pieces} ${spec.frequency.unit}` : "nowhere on the band"}.`);
    const told = edges.map((x) => {
      const limit = CRITERIA.length > 1 ? ` ${percent(region.most(x.part, at(x.omega, values), x.omega))}` : "";
      return `${meets(x)}${limit} at ${often(x.omega)}`;
    });
    const more = told.length > 6 ? `; and ${told.length - 6} more` : "";
    write("explorer-crossings", told.length ? `${told.slice(0, 6).join("; ")}${more}.` : CRITERIA.length > 1 ? "No ratio meets its threshold." : `ΔH never meets the border of the ${spec.region.shape}.`);
  }

  function sayProbe({ omega, v }) {
    const H = (re, im) => (Number.isFinite(re) && Number.isFinite(im) ? `${short(re)} ${im < 0 ? "−" : "+"} ${short(Math.abs(im))} j` : "infinite");
    const rows = { H_env: H(v.environment_real, v.environment_imag), H_perc: H(v.perceived_real, v.perceived_imag) };
    const ratios = PARTS.map((part) => `${part === "real" ? "r_r" : "r_i"} = ${short(v[`ratio_${part}`])}`);
    const noticed = CRITERIA.filter((name) => exceeds(name, { omega, v })).map((name) => ({ real: "in the real part", imag: "in the imaginary part", joint: `(outside the ${spec.region.shape})` })[name]);
    const verdict = noticed.length ? `noticed ${noticed.join(" and ").replace("part and in the", "and the")}` : "not noticed";
    const systems = Object.entries(rows).map(([name, text]) => `${name} = ${text} ${spec.unit}`);
    write("explorer-probe", `At ${often(omega)} ${spec.frequency.unit}: ${[...systems, ...ratios].join(", ")}: ${verdict}.`);
  }

  // All anew.

  function seenIn(top, [x, y], plane) {
    const ranges = [...CRITERIA.map(() => [0, top]), x, y, x, y, ...plane];
    const share = (value, [a, b]) => (Number.isNaN(value) ? 2 : Math.min(Math.max((value - a) / (b - a), -1), 2));
    return (sample) => fields(sample).map((value, i) => share(value, ranges[i]));
  }

  function draw() {
    const even = evenly(300, values);
    const probe = there(values.get("explorer-omega"));
    const lines = region.outline(probe.v, probe.omega).filter((points) => points.flat().every(Number.isFinite));
    const seen = seenIn(ratioTop(even), window_(even), regionWindow(lines));
    const samples = refined(even, seen, values);
    const drawn = [...spec.arguments, ...(CRITERIA.length > 1 ? [] : spec.limits)]; // what moves a curve
    const moved = drawn.some((id) => values.get(id) !== initial.get(id));
    const base = moved ? refined(evenly(300, initial), seen, initial) : null;
    const edges = CRITERIA.flatMap((name) => crossings(samples, name)).sort((a, b) => a.omega - b.omega);
    const bands = transparent(edges);
    drawRatios(samples, base, edges, bands, ratioTop(even), probe);
    drawNyquist(samples, base, window_(even), probe);
    drawRegion(samples, base, lines, edges, probe);
    say(bands, edges);
    sayProbe(probe);
  }

  // What moves.

  let waiting = false;
  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      draw();
    });
  }

  // The sliders.

  const STEPS = 500; // to each side of the middle
  /** The value at a position: four digits in the unit that is shown. */
  function fromPosition(s, n) {
    const share = (n + STEPS) / (2 * STEPS);
    const value = s.log ? s.low * (s.high / s.low) ** share : s.low + (s.high - s.low) * share;
    return s.size * Number((value / s.size).toPrecision(4));
  }
  const toPosition = (s, x) => Math.round(2 * STEPS * (s.log ? Math.log(x / s.low) / Math.log(s.high / s.low) : (x - s.low) / (s.high - s.low)) - STEPS);
  const allowed = (s, x) => Number.isFinite(x) && (s.open ? x > s.least : x >= (s.least ?? -Infinity)) && x <= (s.most ?? Infinity);

  function show(s, { typing } = {}) {
    const [slider, box] = [find(s.id), find(`${s.id}-value`)];
    const value = values.get(s.id);
    slider.value = toPosition(s, value);
    slider.setAttribute("aria-valuetext", `${short(value / s.size)} ${s.unit}`);
    if (!typing) box.value = Number((value / s.size).toPrecision(6));
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
      const typed = box.valueAsNumber * s.size;
      if (!allowed(s, typed)) {
        box.setAttribute("aria-invalid", "true");
        return;
      }
      values.set(s.id, typed);
      show(s, { typing: true });
      redraw();
    });
    box.addEventListener("change", () => show(s));
    show(s);
  });
  find("explorer-reset").addEventListener("click", () => {
    initial.forEach((value, id) => values.set(id, value));
    spec.sliders.forEach((s) => show(s));
    redraw();
  });
  find("explorer-panel").hidden = false;
  draw();
})();
