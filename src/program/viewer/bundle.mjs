// Puts the page, its style and its scripts into one file.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node bundle.mjs OUT [--sources FOLDER] [PACKAGE EXAMPLE...] (in a folder with node_modules)
// FOLDER: OUT is not shortened, and FOLDER gets what it holds of others, with their licences.
// PACKAGE: the folder of the npm package of web/; the page then runs models, with files of models to begin with.
import { cpSync, readFileSync, writeFileSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { deflateSync } from "node:zlib";
import { build } from "esbuild";

const [out, ...rest] = process.argv.slice(2);
const folder = rest[0] === "--sources" ? rest.splice(0, 2)[1] : null;
const [library, ...examples] = rest;
const result = await build({
    entryPoints: library ? ["live.js", "worker.js"] : ["main.js"],
    outdir: ".",
    bundle: true,
    alias: library ? { mbsrank: resolve(library, "mbsrank.js") } : {},
    external: ["node:*"],
    logOverride: { "empty-import-meta": "silent" },
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
    for (const name of names) taken.push(`node_modules/${name}/src`); // what the modules above are made of
    for (const name of taken) cpSync(name, name.replace("node_modules", folder), { recursive: true });
}
const [script, worker] = result.outputFiles.map(({ text }) => text.replace(/<\/script/gi, "<\\/script").replace(/<!--/g, "<\\!--"));
const page = readFileSync("page.html", "utf8");
const parts = { style: readFileSync("style.css", "utf8"), script };
// What stands in the page besides: the module as bytesOf reads it, the script of its thread, and texts of models.
if (library) {
    const texts = Object.fromEntries(examples.map((path) => [basename(path), readFileSync(path, "utf8")]));
    const module = deflateSync(readFileSync(join(library, "mbsrank.wasm")), { level: 9 }).toString("base64");
    parts.script = `</script><script type="text/plain" id="module">z${module}</script>` +
        `<script type="text/plain" id="worker">${worker}</script>` +
        `<script type="application/json" id="examples">${JSON.stringify(texts).replace(/</g, "\\u003c")}</script>` +
        `<script>${script}`;
}
writeFileSync(out, page.replace(/\/\*(style|script)\*\//g, (_, name) => parts[name]));
