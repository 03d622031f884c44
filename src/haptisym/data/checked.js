// On a report: proves the page's certificate anew, holds the page's answer against it, and says what came of that.
(function () {
  "use strict";
  const place = document.getElementById("checked");
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const VERBS = { exceeds: "exceeds", returns: "returns below", touches: "is tangent to" };

  const counted = (n, what) => `${n === 0 ? "no" : n} ${what}${n === 1 ? "" : "s"}`;

  /** A number of a certificate, nearly. */
  function float(text) {
    const [top, bottom] = text.split("/");
    return Number(top) / Number(bottom || 1);
  }

  const near = (text, x) => (text === null || x === null ? text === x : Math.abs(float(text) - x) <= 1e-9 * Math.abs(x));

  /** What the page's answer says otherwise than the claim; empty if nothing. */
  const DIFFERENCES = { evaluation: ofCrossings, stability: ofRoots, requirement: ofValues };

  function ofRoots(claim) {
    const { imposed, held } = read("stability");
    if (imposed.unstable !== claim.imposed) return "the page counts other poles than are proven";
    if (held.length !== claim.held.length) return `the page has ${counted(held.length, "hand")}, and ${claim.held.length} are proven`;
    const wrong = claim.held.findIndex(({ hand, unstable }, i) => {
      const told = held[i];
      const same = typeof hand === "string" ? told.hand.name === hand : ["m", "b", "k"].every((key) => near(hand[key], told.hand[key]));
      return !same || told.unstable !== unstable;
    });
    return wrong < 0 ? "" : `the page says something else of the hand ${held[wrong].hand.name}`;
  }

  function ofValues(claim) {
    const proven = claim.values.filter(([, , holds]) => holds);
    const told = read("requirement").feasible;
    if (told.length !== proven.length) return `the page has ${counted(told.length, "interval")}, and ${proven.length} are proven`;
    return told.every((ends, i) => ends.every((x, k) => near(proven[i][k], x))) ? "" : "the page has other values than are proven";
  }

  function ofCrossings(claim) {
    const rows = [...document.querySelectorAll("#step-1 tbody tr")].filter((row) => /^\[[^\]]+\]$/.test(row.lastElementChild.textContent) && row.children.length > 3);
    if (rows.length !== claim.crossings.length) return `the table shows ${rows.length} crossings, and ${claim.crossings.length} are proven`;
    const wrong = claim.crossings.findIndex((crossing, i) => {
      const cells = [...rows[i].children].map((cell) => cell.textContent);
      const [part, event, enclosure] = [cells[0], cells.at(-3), cells.at(-1)];
      const times = crossing.multiplicity > 1 ? `(${crossing.multiplicity}-fold)` : "";
      const same = part === crossing.part && event.includes(VERBS[crossing.kind]) && event.endsWith(times);
      return !same || enclosure !== `[${claim.frequencies[crossing.at].join(", ")}]`;
    });
    return wrong < 0 ? "" : `row ${wrong + 1} of the table is not what is proven`;
  }

  const WORDS = { evaluation: crossingsTold, stability: rootsTold, requirement: valuesTold };

  function rootsTold({ imposed, held }) {
    const rows = held.map(({ hand, unstable }, i) => `; in the hand ${typeof hand === "string" ? hand : read("stability").held[i].hand.name} ${counted(unstable, "root")}`);
    return `Checked here: ${counted(imposed, "pole")} of H_perc in Re s ≥ 0${rows.join("")}.`;
  }

  function valuesTold({ values }) {
    const shown = (x, otherwise) => (x === null ? otherwise : String(Number(float(x).toPrecision(12))));
    const rows = values.map(([low, high, holds]) => `${holds ? "transparent" : "not transparent"} from ${shown(low, "-∞")} to ${shown(high, "∞")}`);
    return `Checked here: ${rows.join(", ")}.`;
  }

  function crossingsTold(claim) {
    const count = claim.crossings.length;
    const found = `${count === 0 ? "no crossing" : count === 1 ? "1 crossing" : `${count} crossings`}, none missed`;
    if (claim.stable === null) return `Checked here: ${found}. Nothing was checked about poles.`;
    return `Checked here: ${found}; H_perc ${claim.stable ? "has all its poles in Re s < 0" : "has a pole in Re s ≥ 0"}.`;
  }

  place.textContent = "Checking …";
  const prove = () => setTimeout(() => {
    const { claim, why } = haptisymCheck.verdict(read("certificate"), read("certificate-scene"), read("certificate-catalogue"));
    const wrong = claim ? DIFFERENCES[claim.question](claim) : why;
    place.className = wrong ? "failed" : "proven";
    place.textContent = wrong ? `NOT proven here: ${wrong}.` : WORDS[claim.question](claim);
  }, 0);
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", prove); // the answer may stand below
  else prove();
})();
