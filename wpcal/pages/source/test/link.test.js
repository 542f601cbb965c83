import assert from "node:assert/strict";
import test from "node:test";

import { contentOf, FAULTS, latestOnly, post } from "../src/pick/link.js";

function answering(response) {
  return async () => response;
}

test("an answer and a fault of the server come through as they are", async (t) => {
  const fault = { message: "no frame", code: FAULTS.userFrameMissing, row: null, column: null };
  const fetching = t.mock.method(globalThis, "fetch", answering({ ok: true, json: async () => ({ fault }) }));
  assert.deepEqual(await post("read", { a: 1 }), { fault });
  const [action, { method, body }] = fetching.mock.calls[0].arguments;
  assert.deepEqual([action, method, body], ["read", "POST", '{"a":1}']);
});

test("a refusal is a fault with the server's words", async (t) => {
  t.mock.method(globalThis, "fetch", answering({ ok: false, text: async () => "expected JSON" }));
  const { fault } = await post("fit", {});
  assert.deepEqual(fault, { message: "expected JSON", code: "refused", row: null, column: null });
});

test("a server that does not answer is a fault with a code", async (t) => {
  t.mock.method(globalThis, "fetch", async () => {
    throw new TypeError("network");
  });
  const { fault } = await post("fit", {});
  assert.equal(fault.code, FAULTS.noServer);
});

test("requests during a run start one more run, with the latest state", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const ends = [];
  const runner = latestOnly(() => new Promise((resolve) => ends.push(resolve)), 100);
  const turn = () => new Promise((resolve) => setImmediate(resolve));
  runner.ask();
  runner.ask();
  assert.equal(ends.length, 0);
  t.mock.timers.tick(100);
  assert.equal(ends.length, 1);
  runner.ask();
  runner.ask();
  ends[0]();
  await turn();
  assert.equal(ends.length, 2);
  assert.equal(runner.isIdle, false);
  ends[1]();
  await turn();
  assert.equal(ends.length, 2);
  assert.equal(runner.isIdle, true);
});

test("a file that is too large is refused before it is read", async () => {
  const { fault } = await contentOf({ name: "big.csv", size: 6_000_000 });
  assert.match(fault.message, /^big\.csv: is too large/);
});
