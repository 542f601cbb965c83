import assert from "node:assert/strict";
import { test } from "node:test";
import { decided } from "../src/touchup/command.js";

test("what is set aside stands before the output, and names cannot leave their quotes", () => {
  const words = "wpcal touchup back --of out -o NEW";
  assert.equal(decided(words, []), words);
  assert.equal(decided(words, ["W3"]), "wpcal touchup back --of out --set-aside W3 -o NEW");
  assert.equal(
    decided(words, ["a'; rm b", "$&"]),
    "wpcal touchup back --of out --set-aside 'a'\\''; rm b' --set-aside '$&' -o NEW",
  );
});
