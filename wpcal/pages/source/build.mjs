// Builds the bundles that the Python package ships: wpcal/pages/bundles/.
//
// `viewer.js` holds three.js and the viewer once and sets the global `wpcalViewer`; every `src/entries/NAME.js` becomes
// `NAME.js`, which takes `../viewer.js` from that global, and `src/entries/NAME.css` becomes `NAME.css`.
// `node build.mjs --out FOLDER` writes elsewhere; the test of equal bytes uses it.
import { mkdir, readdir, readFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const asked = process.argv.indexOf("--out");
const out = asked < 0 ? join(here, "..", "bundles") : resolve(process.argv[asked + 1]);

const common = {
  absWorkingDir: here,
  bundle: true,
  minify: true,
  target: ["chrome111", "firefox113", "safari16.4"], // the first with DecompressionStream and color-mix, or near it
  charset: "ascii", // a page shows the same in whatever encoding it is taken for
  legalComments: "none", // the whole licence is in the banner
  logLevel: "warning",
};

const licence = await readFile(join(here, "node_modules", "three", "LICENSE"), "utf8");
const { version } = JSON.parse(await readFile(join(here, "node_modules", "three", "package.json"), "utf8"));
const banner = `/*! wpcal viewer (MIT). It contains three.js ${version}:\n\n${licence.trim()}\n*/`;

/** Resolves `…/viewer.js` to the global that the first bundle sets. */
const viewerFromGlobal = {
  name: "viewer-from-global",
  setup(build) {
    build.onResolve({ filter: /\/viewer\.js$/ }, () => ({ path: "viewer", namespace: "global" }));
    build.onLoad({ filter: /.*/, namespace: "global" }, () => ({
      contents: "module.exports = globalThis.wpcalViewer;",
    }));
  },
};

await mkdir(out, { recursive: true });
await esbuild.build({
  ...common,
  entryPoints: ["src/viewer.js"],
  outfile: join(out, "viewer.js"),
  format: "iife",
  globalName: "wpcalViewer",
  banner: { js: banner },
});
const entries = (await readdir(join(here, "src", "entries"))).filter((name) => /\.(js|css)$/.test(name)).sort();
await esbuild.build({
  ...common,
  entryPoints: entries.map((name) => join("src", "entries", name)),
  outdir: out,
  format: "iife",
  plugins: [viewerFromGlobal],
});
