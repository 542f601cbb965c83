// Rules for the sources that the linter does not know.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import test from "node:test";

const ROOT = new URL("../", import.meta.url);
const LONGEST_LINE = 120;
const BY_MESSAGE = /message\??\.(?:includes|match|search|startsWith|endsWith|indexOf)\b|\.test\([^)]*message\)/;

const SOURCES = ["src", "test"].flatMap((folder) =>
  readdirSync(new URL(folder, ROOT), { recursive: true })
    .filter((name) => /\.(?:js|css)$/.test(name))
    .map((name) => `${folder}/${name}`),
);

for (const name of ["build.mjs", ...SOURCES]) {
  test(`${name}: lines of at most ${LONGEST_LINE} characters`, () => {
    const lines = readFileSync(new URL(name, ROOT), "utf8").split("\n");
    const long = lines.flatMap((line, i) => ([...line].length > LONGEST_LINE ? [`line ${i + 1}`] : []));
    assert.deepEqual(long, []);
  });
}

test("no page decides anything by the words of a message: faults have codes", () => {
  const found = SOURCES.filter((name) => name.startsWith("src/")).filter((name) =>
    BY_MESSAGE.test(readFileSync(new URL(name, ROOT), "utf8")),
  );
  assert.deepEqual(found, []);
});
