import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import test from "node:test";

const LEAST = 4.5; // WCAG 2.2, AA, for text
const GROUNDS = ["paper", "ground"];
const TEXTS = ["ink", "soft", "pass", "unsure", "fail", "accent", ...[0, 1, 2, 3, 4, 5].map((i) => `series-${i}`)];

/** The variables of the light and of the dark theme. */
async function themes() {
  const css = await readFile(new URL("../src/base.css", import.meta.url), "utf8");
  const [light, dark] = [...css.matchAll(/:root \{([^}]*)\}/g)].map(([, body]) =>
    Object.fromEntries([...body.matchAll(/--([\w-]+): (#[0-9a-f]{6});/g)].map(([, name, value]) => [name, value])),
  );
  return { light, dark: { ...light, ...dark } };
}

function luminance(colour) {
  const [r, g, b] = [1, 3, 5].map((i) => Number.parseInt(colour.slice(i, i + 2), 16) / 255);
  const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
}

function contrast(a, b) {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
}

test("the formula gives the known contrast of black on white", () => {
  assert.equal(contrast("#000000", "#ffffff"), 21);
});

test("every text colour is readable on every ground of both themes", async () => {
  for (const [theme, colours] of Object.entries(await themes())) {
    for (const ground of GROUNDS) {
      for (const text of TEXTS) {
        const found = contrast(colours[text], colours[ground]);
        assert.ok(found >= LEAST, `${theme}: --${text} on --${ground} has ${found.toFixed(2)}`);
      }
    }
  }
});

test("no page gives a text a colour of its own, which the dark theme could not change", async () => {
  for (const name of ["plan", "report", "seams"]) {
    const css = await readFile(new URL(`../src/entries/${name}.css`, import.meta.url), "utf8");
    const screen = css.split("@media print")[0];
    assert.doesNotMatch(screen, /(?:^|[ {;])(?:color|fill): #/m, name);
  }
});
