import "./document.js";

import assert from "node:assert/strict";
import test from "node:test";

import { foundSeams, SeamList } from "../src/seams/list.js";
import { memberTable, wordOf } from "../src/seams/members.js";

const seam = (name, solids, length_mm, against = []) => ({
  ...{ name, solids, length_mm, against, joint: "tee", weld: "fillet", confidence: 0.9 },
  accepted: !against.length,
});
const SEAMS = [
  seam("W10", ["post", "base"], 40),
  seam("W9", ["post", "M8 bolt"], 5, ["M8 bolt is a bolt or screw"]),
  seam("W2", ["post", "rib"], 80),
];
const MEMBERS = [
  { solid: "post", taken_as: "a member", factor: 1, why: ["nothing speaks against welding it"] },
  { solid: "M8 bolt", taken_as: "a bolt or screw", factor: 0.05, why: ["shape and seat"] },
];

function listOf({ onChoose = () => {}, onTick = () => {} }) {
  const list = new SeamList({ onChoose, onTick, members: MEMBERS });
  list.show(SEAMS, null, new Set(["W9"]));
  return list;
}

const namesIn = ({ element }) => [...element.querySelectorAll("tbody tr")].map((row) => row.getAttribute("data-name"));

test("seams are found by every word of their line, and by what they are", () => {
  const names = (kind, text) => foundSeams(SEAMS, kind, text).map(({ name }) => name);
  assert.deepEqual(names("all", ""), ["W10", "W9", "W2"]);
  assert.deepEqual(names("refused", ""), ["W9"]);
  assert.deepEqual(names("accepted", "RIB post"), ["W2"]);
  assert.deepEqual(names("all", "screw"), ["W9"]);
});

test("a head sorts, and sorts the other way; names by their numbers", () => {
  const list = listOf({});
  list.sort = { title: "length mm", sign: 1 };
  list.fill();
  assert.deepEqual(namesIn(list), ["W9", "W10", "W2"]);
  list.sort = { title: "seam", sign: 1 };
  list.fill();
  assert.deepEqual(namesIn(list), ["W2", "W9", "W10"]);
  assert.equal(list.element.querySelector("[aria-sort]").getAttribute("aria-sort"), "ascending");
});

test("a tick is said with the names of the seams, and is shown", () => {
  const list = listOf({});
  const ticks = [...list.element.querySelectorAll("tbody .tick")].map((box) => box.hasAttribute("checked"));
  assert.deepEqual(ticks, [false, true, false]);
});

test("a refused seam leads to what its solid is taken for", () => {
  const list = listOf({});
  const links = [...list.element.querySelectorAll("tr[data-name=W9] a")].map((link) => link.getAttribute("href"));
  assert.deepEqual(links, ["#solid-1", "#solid-2"]);
  const table = memberTable(MEMBERS, () => {});
  assert.match(table.querySelector("#solid-2").textContent, /M8 bolt.*a bolt or screw.*shape and seat/);
  assert.equal(
    memberTable([], () => {}),
    null,
  );
});

test("members of a solid have rows of their own, and what is said of each is shown and said", () => {
  const of = (name, kind, seams) => ({ name, kind, seams, length_mm: 100, mass_kg: 2, weld_mm: 80 });
  const listed = [of("post", "", ["W2"]), of("post/1", "tube 50 x 50 x 4 mm", ["W2"]), of("post/2", "plate 10 mm", [])];
  const members = [{ ...MEMBERS[0], listed }];
  const judging = { weld: [], not: [], members: [{ member: "post/1", is: "post/2" }] };
  assert.deepEqual(
    listed.map((row) => wordOf(row, judging)),
    ["rules", "post/2", "rules"],
  );
  assert.equal(wordOf({ name: "post", said: false }, judging), "not");
  const said = [];
  const table = memberTable(members, () => {}, { onSay: (...words) => said.push(words), judging });
  const rows = [...table.querySelectorAll("tbody tr")].map((row) => row.textContent);
  assert.equal(rows.length, 3);
  assert.match(rows[1], /post\/1.*tube 50 x 50 x 4 mm.*one with post\/2.*100.*2\.00.*80/);
  assert.match(table.querySelector("caption").textContent, /2\.00 kg/);
  const [, first, second] = table.querySelectorAll(".tick");
  for (const box of [first, second]) {
    box.checked = true;
    box.dispatchEvent(new Event("change"));
  }
  table.querySelector(".together").click();
  assert.deepEqual(said, [["post/1", "post/2"]]);
  assert.deepEqual(
    foundSeams(SEAMS, "all", "post/1", members).map(({ name }) => name),
    ["W2"],
  );
});
