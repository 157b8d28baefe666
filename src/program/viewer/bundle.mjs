// Puts the page, its style and its scripts into one file.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node bundle.mjs OUT [FOLDER] (in a folder with node_modules)
// FOLDER: OUT is not shortened, and FOLDER gets what it holds of others, with their licences.
import { cpSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const [out, folder] = process.argv.slice(2);
const result = await build({
    entryPoints: ["main.js"],
    bundle: true,
    minify: !folder,
    metafile: true,
    format: "iife",
    target: "es2020",
    legalComments: "inline",
    write: false,
});
if (folder) {
    const taken = Object.keys(result.metafile.inputs).filter((name) => name.startsWith("node_modules/"));
    const names = new Set(taken.map((name) => name.split("/")[1]));
    for (const name of names) taken.push(...["LICENSE", "package.json"].map((file) => `node_modules/${name}/${file}`));
    if (names.has("mediabunny")) taken.push("node_modules/mediabunny/src");
    for (const name of taken) cpSync(name, name.replace("node_modules", folder), { recursive: true });
}
const script = result.outputFiles[0].text.replace(/<\/script/gi, "<\\/script").replace(/<!--/g, "<\\!--");
const page = readFileSync("page.html", "utf8");
const parts = { style: readFileSync("style.css", "utf8"), script };
writeFileSync(out, page.replace(/\/\*(style|script)\*\//g, (_, name) => parts[name]));
