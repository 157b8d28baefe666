// Puts the page, its style and its scripts into one file.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node bundle.mjs OUT (in a folder with node_modules)
import { readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const out = process.argv[2];
const result = await build({
    entryPoints: ["main.js"],
    bundle: true,
    minify: true,
    format: "iife",
    target: "es2020",
    legalComments: "inline",
    write: false,
});
const script = result.outputFiles[0].text.replace(/<\/script/gi, "<\\/script").replace(/<!--/g, "<\\!--");
const page = readFileSync("page.html", "utf8");
const parts = { style: readFileSync("style.css", "utf8"), script };
writeFileSync(out, page.replace(/\/\*(style|script)\*\//g, (_, name) => parts[name]));
