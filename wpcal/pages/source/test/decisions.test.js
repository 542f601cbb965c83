import assert from "node:assert/strict";
import test from "node:test";

import { changesBy, decisionsAfter, decisionsOf, Refusal } from "../src/seams/decisions.js";
import { meetingRows, placesAlong } from "../src/seams/ends.js";
import { seamsFile } from "../src/seams/file.js";
import { previewed } from "../src/seams/preview.js";

const EYE = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];

function seamFrom(name, start, end, edit) {
  const length = Math.hypot(...end.map((v, i) => v - start[i]));
  const candidate = { name, start_part_mm: start, length_mm: length };
  const frames = { s: [0, length], p: [start, end], R: [EYE, EYE] };
  return { seam: { name, candidate, length_mm: length, accepted: true, against: [], inside: [], edit }, frames };
}

function stateOf(...parts) {
  return { seams: parts.map(({ seam }) => seam), frames: parts.map(({ frames }) => frames) };
}

const A = seamFrom("W1", [0, 0, 0], [100, 0, 0]);
const B = seamFrom("W2", [100, 0, 0], [100, 50, 0]);
const C = seamFrom("W3", [0, 90, 0], [100, 90, 0]);

const editsOf = (decisions) => decisions.map(({ candidate, edit }) => [candidate.name, edit]);

test("accept, refuse, turn and the other side are said once and taken back", () => {
  const { seams } = stateOf(A, B);
  const edit = (seam, kind) => changesBy([seam], { kind, row: 0 }).edits.get(0)[0];
  const refused = { ...seams[0], edit: edit(seams[0], "refuse") };
  assert.deepEqual(refused.edit, { reject: true });
  assert.deepEqual(edit(refused, "accept"), { accept: true });
  const turned = { ...seams[0], edit: edit(seams[0], "turn") };
  assert.deepEqual([turned.edit, edit(turned, "turn")], [{ reverse: true }, {}]);
  assert.deepEqual(decisionsAfter([turned], { kind: "turn", row: 0 }), []);
  assert.deepEqual(edit(seams[0], "otherSide"), { other_side: true });
});

test("several seams are accepted or refused at once", () => {
  const state = stateOf(A, B, C);
  const next = previewed(state, { kind: "refuse", rows: [0, 2] });
  assert.deepEqual(
    next.seams.map(({ accepted, edit }) => [accepted, edit]),
    [
      [false, { reject: true }],
      [true, undefined],
      [false, { reject: true }],
    ],
  );
  assert.deepEqual(
    previewed(next, { kind: "accept", rows: [0, 2] }).seams.map(({ accepted }) => accepted),
    [true, true, true],
  );
});

test("seams are joined as far as wpcal joins them, and the bridge is a part of the seam", () => {
  const state = stateOf(A, seamFrom("W2", [104, 0, 0], [150, 0, 0]));
  assert.deepEqual([meetingRows(state, 0, 1), meetingRows(state, 0, 5)], [[], [1]]);
  const { seams, frames } = previewed(state, { kind: "join", row: 0, other: 1 });
  assert.equal(seams[0].length_mm, 150);
  assert.deepEqual(frames[0].s, [0, 100, 104, 150]);
});

test("a cut is measured from where the torch starts", () => {
  const { seams } = stateOf(A);
  const halves = decisionsAfter(seams, { kind: "cut", row: 0, s: 30 });
  assert.deepEqual(editsOf(halves), [
    ["W1", { range_mm: [0, 30], name: "W1a" }],
    ["W1", { range_mm: [30, 100], name: "W1b" }],
  ]);
  const turned = [{ ...seams[0], edit: { reverse: true } }];
  assert.deepEqual(
    decisionsAfter(turned, { kind: "cut", row: 0, s: 30 }).map(({ edit }) => edit.range_mm),
    [
      [70, 100],
      [0, 70],
    ],
  );
  for (const s of [0, 100, -1, Number.NaN])
    assert.throws(() => decisionsAfter(seams, { kind: "cut", row: 0, s }), /Cut between 0 and 100.0 mm/);
});

test("two halves joined again are the seam as it was found", () => {
  const cut = previewed(stateOf(A), { kind: "cut", row: 0, s: 30 });
  const whole = decisionsAfter(cut.seams, { kind: "join", row: 0, other: 1 });
  assert.deepEqual(whole, []);
});

test("seams that meet are joined, and separated again", () => {
  const state = stateOf(A, B, C);
  assert.deepEqual(
    [0, 1, 2].map((row) => meetingRows(state, row, 1)),
    [[1], [0], []],
  );
  const joined = previewed(state, { kind: "join", row: 0, other: 1 });
  assert.deepEqual(
    joined.seams.map(({ name, length_mm }) => [name, length_mm]),
    [
      ["W1", 150],
      ["W3", 100],
    ],
  );
  assert.deepEqual(joined.frames[0].p, [
    [0, 0, 0],
    [100, 0, 0],
    [100, 50, 0],
  ]);
  assert.deepEqual(editsOf(decisionsOf(joined.seams)), [["W1", { join: [{ candidate: B.seam.candidate }] }]]);
  assert.deepEqual(decisionsAfter(joined.seams, { kind: "separate", row: 0 }), []);
  assert.throws(() => decisionsAfter(joined.seams, { kind: "cut", row: 0, s: 10 }), Refusal);
});

test("a joined stretch is a seam of its own again when it is separated", () => {
  const cut = previewed(stateOf(A, B), { kind: "cut", row: 0, s: 30 });
  const joined = previewed(cut, { kind: "join", row: 1, other: 2 });
  assert.deepEqual(editsOf(decisionsOf(joined.seams)).at(-1), [
    "W1",
    { range_mm: [30, 100], name: "W1b", join: [{ candidate: B.seam.candidate }] },
  ]);
  const back = decisionsAfter(joined.seams, { kind: "separate", row: 1 });
  assert.deepEqual(editsOf(back), editsOf(decisionsOf(cut.seams)));
});

test("a name is given once", () => {
  const { seams } = stateOf(A, B);
  assert.deepEqual(editsOf(decisionsAfter(seams, { kind: "rename", row: 0, name: " left " })), [
    ["W1", { name: "left" }],
  ]);
  assert.throws(() => decisionsAfter(seams, { kind: "rename", row: 0, name: "W2" }), /Another seam is called W2/);
  assert.throws(() => decisionsAfter(seams, { kind: "rename", row: 0, name: " " }), /Type a name/);
});

test("the preview turns the frames, and never accepts what is inside material", () => {
  const back = previewed(stateOf(A), { kind: "turn", row: 0 });
  assert.deepEqual(back.frames[0].p, A.frames.p.toReversed());
  assert.deepEqual(back.frames[0].R[0], [
    [-1, 0, 0],
    [0, -1, 0],
    [0, 0, 1],
  ]);
  const inside = { seam: { ...A.seam, accepted: false, inside: ["block"] }, frames: A.frames };
  assert.equal(previewed(stateOf(inside), { kind: "accept", row: 0 }).seams[0].accepted, false);
});

test("a pointer on a seam is between its frames, too", () => {
  const { p, s, rows } = placesAlong(A.frames);
  assert.deepEqual([s[4], p[4], rows[4], rows[5], s.length], [40, [40, 0, 0], 0, 1, 11]);
});

test("the file has decisions and no frames", () => {
  const state = stateOf(A, B, C);
  const record = { schema: "wpcal/seams/1", frame: "part", seams: state.seams.map(({ edit, ...seam }) => seam) };
  const after = previewed(previewed(state, { kind: "refuse", row: 2 }), { kind: "cut", row: 0, s: 30 });
  const file = seamsFile(record, after.seams);
  assert.deepEqual(
    file.seams.map(({ name, edit, frames, accepted, length_mm }) => [name, edit, frames.length, accepted, length_mm]),
    [
      ["W1a", { range_mm: [0, 30], name: "W1a" }, 0, true, 100],
      ["W1b", { range_mm: [30, 100], name: "W1b" }, 0, true, 100],
      ["W2", undefined, 0, true, 50],
      ["W3", { reject: true }, 0, true, 100],
    ],
  );
});
