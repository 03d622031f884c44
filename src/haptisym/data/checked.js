// On a report: proves the page's certificate anew, holds the table of crossings against it, and says what came of that.
(function () {
  "use strict";
  const place = document.getElementById("checked");
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const VERBS = { exceeds: "rises above", returns: "falls below", touches: "touches" };

  /** What the table of crossings says otherwise than the claim; empty if nothing. */
  function difference(claim) {
    const rows = [...document.querySelectorAll("#step-1 tbody tr")].filter((row) => /^\[[^\]]+\]$/.test(row.lastElementChild.textContent) && row.children.length === 6);
    if (rows.length !== claim.crossings.length) return `the table shows ${rows.length} crossings, and ${claim.crossings.length} are proven`;
    const wrong = claim.crossings.findIndex((crossing, i) => {
      const [part, , , event, , enclosure] = [...rows[i].children].map((cell) => cell.textContent);
      const times = crossing.multiplicity > 1 ? `(${crossing.multiplicity}-fold)` : "";
      const same = part === crossing.part && event.includes(VERBS[crossing.kind]) && event.endsWith(times);
      return !same || enclosure !== `[${claim.frequencies[crossing.at].join(", ")}]`;
    });
    return wrong < 0 ? "" : `row ${wrong + 1} of the table is not what is proven`;
  }

  function told(claim) {
    const count = claim.crossings.length;
    const found = `${count === 0 ? "no crossing" : count === 1 ? "1 crossing" : `${count} crossings`}, none missed`;
    if (claim.stable === null) return `Checked here: ${found}. Nothing was checked about poles.`;
    return `Checked here: ${found}; H_perc ${claim.stable ? "has all its poles in Re s < 0" : "has a pole in Re s ≥ 0"}.`;
  }

  place.textContent = "Checking …";
  setTimeout(() => {
    const { claim, why } = haptisymCheck.verdict(read("certificate"), read("certificate-scene"), read("certificate-catalogue"));
    const wrong = claim ? difference(claim) : why;
    place.className = wrong ? "failed" : "proven";
    place.textContent = wrong ? `NOT proven here: ${wrong}.` : told(claim);
  }, 0);
})();
