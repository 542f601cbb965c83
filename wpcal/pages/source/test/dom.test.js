import assert from "node:assert/strict";
import test from "node:test";

import { drawAllLines, el, facts, fixed, short, signed, table } from "../src/dom.js";
import { plural, verdictText } from "../src/words.js";
import { texts } from "./document.js";

test("numbers with fixed decimals have no minus zero and a dash for nothing", () => {
  assert.deepEqual([fixed(1.23456), fixed(-0.0001), fixed(null), fixed(Number.NaN)], ["1.235", "0.000", "–", "–"]);
  assert.deepEqual([signed(0.5, 1), signed(-0.5, 1), signed(0.0001)], ["+0.5", "-0.5", "0.000"]);
});

test("short numbers have three digits, very large and very small ones an exponent", () => {
  assert.deepEqual([0, 1234.5, 0.25, 300000, 0.0002].map(short), ["0", "1230", "0.25", "3e5", "2e-4"]);
});

test("text never becomes markup", () => {
  const element = el("p", { title: "<b>" }, "<img src=x>", null, [undefined, "y"]);
  assert.equal(element.children.length, 0);
  assert.equal(element.textContent, "<img src=x>y");
  assert.equal(element.getAttribute("title"), "<b>");
});

test("attributes that are false, null or undefined are left out; true is empty", () => {
  const element = el("input", { hidden: true, checked: false, list: null, name: undefined });
  assert.deepEqual(
    [...element.attributes].map(({ name }) => name),
    ["hidden"],
  );
});

test("a table has a head, one line per row, and classes for numbers", () => {
  const columns = [
    { title: "name", cell: ({ name }) => name },
    { title: "mm", number: true, cell: ({ mm }) => fixed(mm, 1) },
  ];
  const made = table(columns, [{ name: "A", mm: 2 }], { caption: "c", rowOf: () => ({ class: "bad" }) });
  assert.deepEqual(texts(made, "th"), ["name", "mm"]);
  assert.deepEqual(texts(made, "tr.bad td"), ["A", "2.0"]);
  assert.deepEqual(texts(made, "td.number"), ["2.0"]);
  assert.deepEqual(texts(made, "caption"), ["c"]);
});

test("facts are terms with descriptions", () => {
  const made = facts([["length", "3 mm"]]);
  assert.deepEqual([texts(made, "dt"), texts(made, "dd")], [["length"], ["3 mm"]]);
});

test("words that are counted, and the verdict", () => {
  assert.deepEqual([plural(1, "row"), plural(0, "row"), plural(2, "row")], ["1 row", "0 rows", "2 rows"]);
  const judgement = { sentence: "seam W1 is within 0.3 mm" };
  assert.equal(verdictText({ judgement }), "Seam W1 is within 0.3 mm.");
  assert.match(verdictText({ verdict: "FAIL", tolerance_mm: 0.4 }), /older version/);
});

test("of a long table the lines are drawn where one looks, and all of them for the printer", () => {
  let look = null;
  globalThis.IntersectionObserver = class {
    constructor(seen) {
      look = () => seen([{ isIntersecting: true }]);
    }
    observe() {}
  };
  const rows = Array.from({ length: 650 }, (_, k) => ({ name: `W${k + 1}` }));
  const made = table([{ title: "seam", cell: ({ name }) => name }], rows);
  const drawn = () => [made.querySelectorAll("tbody tr:not(.more)").length, texts(made, "tr.more")[0]];
  assert.deepEqual(drawn(), [200, "450 more lines"]);
  look();
  assert.deepEqual(drawn(), [400, "250 more lines"]);
  document.body.append(made);
  drawAllLines();
  assert.deepEqual(drawn(), [650, undefined]);
  assert.equal(texts(made, "tbody tr").at(-1), "W650");
});
