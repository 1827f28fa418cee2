// Bundles src/ and uPlot into the script and the style that the program carries.

import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build, version as esbuildVersion } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const target = join(here, "../src/gyrator/plots/web");
const read = (name) => readFileSync(join(here, name), "utf8");

// A test compares this digest with the sources (tests/cli/web_bundle_test.py).
const sources = ["build.mjs", "figures.css", "package-lock.json", "package.json"]
  .concat(readdirSync(join(here, "src")).map((name) => `src/${name}`))
  .sort();
const digest = createHash("sha256");
for (const name of sources) digest.update(`${name}\n`).update(read(name));

const uplot = JSON.parse(read("node_modules/uplot/package.json"));
const banner = `/*
Made by web/build from web/src with uPlot ${uplot.version} and esbuild ${esbuildVersion}; do not edit.
Sources: sha256 ${digest.digest("hex")}

The figures are gyrator's, MIT licence. uPlot ${uplot.version}:

${read("node_modules/uplot/LICENSE").trim()}
*/`;

const common = { bundle: true, minify: true, target: "es2020", charset: "ascii", legalComments: "none" };
await build({
  ...common,
  entryPoints: [join(here, "src/interactive-figures.js")],
  format: "iife",
  banner: { js: banner },
  outfile: join(target, "figures.js"),
});
await build({
  ...common,
  stdin: {
    contents: '@import "./node_modules/uplot/dist/uPlot.min.css"; @import "./figures.css";',
    resolveDir: here,
    loader: "css",
  },
  banner: { css: banner.slice(0, banner.indexOf("\n\n")) + "\n*/" },
  outfile: join(target, "figures.css"),
});
writeFileSync(join(target, "LICENSE-uPlot"), read("node_modules/uplot/LICENSE"));
