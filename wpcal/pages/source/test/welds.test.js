import assert from "node:assert/strict";
import test from "node:test";

import { Statements } from "../src/welds/statements.js";
import { limitsOf, misfit, shown, valueFrom } from "../src/welds/values.js";

const of = (from, given, name = "") => ({ from, given, ...(name ? { of: name } : {}) });
const PLACE = { start_part_mm: [0, 0, 0], middle_part_mm: [5, 0, 0], length_mm: 10 };
const RULES = {
  values: { leg_mm: 6.5, job: 1 },
  origin: { leg_mm: of("rule", 6.5, "row"), job: of("rule", 1, "row") },
};
const weld = (name, values, origin) => ({ name, place: PLACE, length_mm: 100, values, origin, rules: RULES });

function statements() {
  const welds = [
    weld(
      "W1",
      { leg_mm: 5, passes: 2, root_gap_mm: 1, thickness_mm: 8 },
      {
        leg_mm: of("user", 5),
        passes: of("rule", 2, "one bead"),
        root_gap_mm: of("file", 1, "welds.xml"),
        thickness_mm: of("file", 8, "part.glb"),
      },
    ),
    weld("W2", { leg_mm: 6.5 }, { leg_mm: of("rule", 6.5, "row") }),
  ];
  const left = [{ name: "W9", values: { job: 4 } }];
  return new Statements({ welds, head: { schema: "s" }, without_seam: left, found_again: ["part.glb"] });
}

test("what is stated is shown, goes back to the rule, and can be undone", () => {
  const all = statements();
  assert.equal(all.isChanged, false);
  all.state([0], "leg_mm", undefined);
  assert.deepEqual(all.value(0, "leg_mm"), { value: 6.5, from: "rule", of: "row", isStale: true });
  assert.equal(all.value(0, "passes").isStale, true);
  assert.equal(all.value(1, "leg_mm").isStale, false);
  all.undo();
  assert.deepEqual([all.value(0, "leg_mm").value, all.isChanged], [5, false]);
  all.redo();
  assert.equal(all.value(0, "leg_mm").value, 6.5);
});

test("the saved file holds what people and files stated, and what went back", () => {
  const all = statements();
  all.state([0, 1], "throat_mm", 4);
  all.state([1], "crater", null);
  assert.equal(all.value(1, "leg_mm").value, undefined); // one of the two sizes
  const [first, second] = all.file().welds;
  assert.deepEqual(first.values, { root_gap_mm: 1, throat_mm: 4 });
  assert.deepEqual(first.origin, { root_gap_mm: of("file", 1, "welds.xml"), throat_mm: of("user", 4) });
  assert.deepEqual(first.given_back, ["leg_mm"]);
  assert.deepEqual([second.values, second.given_back], [{ throat_mm: 4, crater: null }, undefined]);
  assert.deepEqual(all.file().without_seam, [{ name: "W9", values: { job: 4 } }]);
});

test("a value that is out of its limits or does not fit is refused with a sentence", () => {
  const part = (name, more) => ({ name, label: name, unit: "mm", is_needed: true, kind: "number", high: 100, ...more });
  const leg = { name: "leg_mm", is_record: false, parts: [part("leg_mm", { low: 0, is_low_open: true })] };
  assert.deepEqual(valueFrom(leg, { leg_mm: "6,5" }), { value: 6.5 });
  assert.equal(valueFrom(leg, { leg_mm: "0" }).fault, "leg_mm: expected above 0 to 100 mm, got 0");
  assert.equal(valueFrom(leg, { leg_mm: "" }).fault, "leg_mm: expected above 0 to 100 mm");
  assert.match(limitsOf(part("passes", { kind: "whole", low: 1, unit: "" })), /a whole number, 1 to 100/);
  const stitch = { length_mm: 50, pitch_mm: 20 };
  assert.match(misfit("stitch", stitch, { name: "W1", length_mm: 100 }), /pitch of 20 mm is shorter/);
  assert.match(misfit("tacks", { length_mm: 50, pitch_mm: 60 }, { name: "W1", length_mm: 40 }), /no room for 50 mm/);
  const all = statements();
  assert.match(all.state([0], "stitch", stitch), /shorter/);
  assert.equal(all.isChanged, false);
  assert.equal(shown({ is_record: true }, stitch), "50 / 20");
});
