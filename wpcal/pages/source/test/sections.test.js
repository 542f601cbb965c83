import "./document.js";
import assert from "node:assert/strict";
import test from "node:test";

import { budgetSection, fitSection, poseSection, seamsSection } from "../src/report/sections.js";

const RECORD = {
  criterion: "minimax",
  objective_mm: 0.25,
  lower_bound_mm: 0.25,
  certified: true,
  rms_mm: 0.2,
  seed: 0,
  solver: { method: "annealing" },
  correction: { six_tuple: { x_mm: 1, y_mm: 2, z_mm: 3, alpha_rad: 0.01, beta_rad: 0.02, gamma_rad: 0.03 } },
  T_base_part: [
    [1, 0, 0, 812.4942],
    [0, 1, 0, -240.2511],
    [0, 0, 1, 155.75],
    [0, 0, 0, 1],
  ],
};
const SEAM = { joint: "tee", weld: "fillet", solids: ["a", "b"], length_mm: 10, gap_mm: { min: 0, max: 0 } };
const FRAMES = { s: [0, 10], p: [], R: [], u95: [0.1, 0.2], position: ["PB", "PB"], slope: null, rotation: null };

function seamsWith(...changes) {
  const seams = changes.map((change, row) => ({ ...SEAM, name: `W${row + 1}`, accepted: true, ...change }));
  return seamsSection(
    seams,
    seams.map(() => FRAMES),
    0.5,
    () => {},
  );
}

test("the pose is one line per pendant", () => {
  const shown = poseSection(RECORD, { KUKA: "A 0.0000  B 0.0000  C 0.0000 deg", UR: "RX 0  RY 0  RZ 0 rad" });
  const lines = [...shown.querySelectorAll("tbody tr")].map((line) => line.textContent);
  assert.equal(lines.length, 2);
  assert.match(lines[0], /^KUKAX 812\.494 {2}Y -240\.251 {2}Z 155\.750 mmA 0\.0000/);
});

test("the proof, radians and the matrix are behind details", () => {
  const shown = fitSection(RECORD);
  const details = shown.querySelector("details");
  assert.match(details.textContent, /objective.*no rigid fit is below.*certified.*rad/);
  assert.ok(details.querySelector("table.matrix"));
  details.remove();
  assert.match(shown.textContent, /criterion.*RMS/);
  assert.doesNotMatch(shown.textContent, /rad|objective|below/);
});

test("the budget of the worst seam comes first, with a bar of its shares", () => {
  const seam = (name, error_95_mm, touching) => ({
    seam: name,
    error_95_mm,
    standard_uncertainty_mm: 0.1,
    coverage_factor: 2,
    shares: { touching, tool: 0, robot: 1 - touching },
  });
  const contributions = ["touching", "tool", "robot"].map((name) => ({ name, type: "B", source: "stated" }));
  const budget = { contributions, seams: [seam("W1", 0.2, 0.25), seam("W2", 0.3, 0.75)] };
  const shown = budgetSection({ budget });
  const rows = [...shown.querySelectorAll("tbody tr")];
  assert.match(rows[0].textContent, /^W20\.3000\.1002\.00touching 75 %, robot 25 %/);
  assert.deepEqual(
    [...rows[1].querySelectorAll(".fill")].map((fill) => fill.style.width),
    ["25.0%", "75.0%"],
  );
  assert.equal(budgetSection({ budget, bodies: {} }), null);
});

test("refused seams are folded and say why; without one there is no such table", () => {
  const refused = seamsWith({}, { accepted: false, against: ["the gap is 0.4 mm", "short"], edit: { accept: false } });
  const folded = refused.querySelector("details");
  assert.equal(refused.querySelectorAll("tbody tr").length - folded.querySelectorAll("tbody tr").length, 1);
  assert.equal(
    folded.querySelector("tbody tr").lastElementChild.textContent,
    "rejected by hand; the gap is 0.4 mm; short",
  );
  assert.doesNotMatch(seamsWith({}).textContent, /not accepted/);
});
