// Bundle the viewer with three.js into src/meshmark/web/viewer/viewer.bundle.js:
// npm install --prefix tools/viewer && node tools/viewer/build_viewer.mjs
//
// The first line of the bundle names what it was made of; tests/web/test_viewer.py compares it with the sources.

import { createHash } from "node:crypto";
import { readFileSync, readdirSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const folder = here("../../src/meshmark/web/viewer/");
const hash = createHash("sha256");
for (const name of readdirSync(`${folder}source`).sort()) hash.update(readFileSync(`${folder}source/${name}`));
const licence = readFileSync(here("node_modules/three/LICENSE"), "utf8").trim();
const { three, esbuild } = JSON.parse(readFileSync(here("package.json"), "utf8")).devDependencies;

await build({
  entryPoints: [`${folder}source/page.js`],
  outfile: `${folder}viewer.bundle.js`,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  nodePaths: [here("node_modules")],
  banner: {
    js:
      `/* meshmark viewer, sources ${hash.digest("hex")}, three ${three}, esbuild ${esbuild}.\n` +
      `three.js is in it, under this licence:\n\n${licence} */`,
  },
});
