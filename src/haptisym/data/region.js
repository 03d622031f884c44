// A JND region in the explorer, in floats: what is judged at a frequency, and the region as it is there.
// `spec` has the shape and, by name, each number: a slider, or a quotient of polynomials in omega, ascending.
function haptisymRegion(spec, values) {
  "use strict";
  const PARTS = ["real", "imag"];
  const polynomial = (p, x) => p.reduceRight((y, c) => y * x + c, 0);
  const number = (x, omega) => ("slider" in x ? values.get(x.slider) : polynomial(x.top, omega) / polynomial(x.bottom, omega));
  const limit = (key, omega) => number(spec.numbers[key], omega);
  const isJoint = spec.shape !== "square";
  const sized = (v) => Math.hypot(v.environment_real, v.environment_imag);

  /** Re dH and Im dH relative to |H_env|. */
  const change = (v) => PARTS.map((part) => (v[part] < 0 ? -1 : 1) * v[`ratio_${part}`]);

  /** Corners, which are given in half widths. */
  const corners = (omega) => spec.corners.map((pair) => pair.map((x, i) => number(x, omega) * limit(PARTS[i], omega)));

  /** How many times a region that judges both parts must be enlarged to hold a change. */
  function enlarged([x, y], omega) {
    if (spec.corners.length) {
      const at = corners(omega);
      return Math.max(...at.map(([a, b], i) => {
        const [right, up] = at[(i + 1) % at.length];
        return ((up - b) * x + (a - right) * y) / (a * up - b * right);
      }));
    }
    const [u, w] = [x / limit("real", omega), y / limit("imag", omega)];
    const t = limit("tilt", omega);
    return Math.sqrt((u * u + w * w - 2 * t * u * w) / (1 - t * t));
  }

  /** What is judged, and what it must not exceed. */
  const judged = (name, v, omega) => (isJoint ? enlarged(change(v), omega) : v[`ratio_${name}`]);

  function most(part, v, omega) {
    if (isJoint) return 1;
    const [higher, lower] = ways(part, sized(v), omega);
    const grown = Math.abs(v[`perceived_${part}`]) - Math.abs(v[`environment_${part}`]);
    return grown > 0 ? higher : grown < 0 ? lower : Math.max(higher, lower);
  }

  /** The limits of a part for changes that make it larger, and smaller. */
  function ways(part, size, omega) {
    const least = "floor" in spec.numbers ? limit("floor", omega) / size : 0;
    return [part, `${part}.lower`].map((key) => Math.max(least, limit(key in spec.numbers ? key : part, omega)));
  }

  /** The changes of one part that are not noticed, as intervals; `own`: that part of H_env relative to |H_env|. */
  function stretches(part, own, size, omega) {
    const [higher, lower] = ways(part, size, omega);
    const [way, turn] = [own >= 0 ? 1 : -1, 2 * Math.abs(own)]; // beyond its mirror image a part grows again
    const [grown, again, shrunk] = [way * higher, -way * higher, -way * Math.min(lower, turn)];
    const found = higher <= turn ? [[shrunk, grown]] : lower >= turn ? [[again, grown]] : [[shrunk, grown], [again, -way * turn]];
    return found.map((ends) => ends.sort((a, b) => a - b));
  }

  /** The region at a frequency, in the plane of Re dH and Im dH over |H_env|: closed lines, none where H_env is zero. */
  function outline(v, omega) {
    if (spec.corners.length) return [corners(omega)];
    if (isJoint) {
      return [Array.from({ length: 361 }, (_, i) => {
        const ray = [Math.cos((i * Math.PI) / 180), Math.sin((i * Math.PI) / 180)];
        return ray.map((x) => x / enlarged(ray, omega));
      })];
    }
    const size = sized(v);
    if (!(size > 0 && Number.isFinite(size))) return [];
    const [across, up] = PARTS.map((part) => stretches(part, v[`environment_${part}`] / size, size, omega));
    return across.flatMap(([a, b]) => up.map(([c, d]) => [[a, c], [b, c], [b, d], [a, d]]));
  }

  return { criteria: isJoint ? ["joint"] : PARTS, judged, most, change, outline };
}
