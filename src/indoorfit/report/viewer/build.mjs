// Writes three.min.js and three.LICENSE.txt beside this file; see package.json.
import { build } from "esbuild";
import { copyFileSync, readFileSync } from "node:fs";

const { version } = JSON.parse(readFileSync("node_modules/three/package.json", "utf8"));
await build({
  entryPoints: ["entry.js"],
  outfile: "three.min.js",
  bundle: true,
  minify: true,
  format: "iife",
  globalName: "THREE",
  target: "es2020",
  charset: "ascii",
  legalComments: "none",
  banner: { js: `/* three.js ${version} with OrbitControls. Copyright 2010-2026 three.js authors. SPDX-License-Identifier: MIT */` },
});
copyFileSync("node_modules/three/LICENSE", "three.LICENSE.txt");
