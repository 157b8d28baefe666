// The page that runs models: by `mbsrank view --live`, or of a file that is opened or dropped.
// SPDX-License-Identifier: BSD-3-Clause
import { load } from "mbsrank";
import { show, showCounts } from "./app.js";
import { bytesOf, readData } from "./data.js";
import { $, element, note } from "./dom.js";
import { Hand } from "./hand.js";
import { Parameters } from "./parameters.js";
import { Simulation } from "./simulate.js";
import { isSoftware } from "./stage.js";
import { showReport } from "./tables.js";

const kinds = /[.](urdf|xml|mjcf|sdf|xacro)$/i;
let library, module, worker, empty, running, texts; // worker: where its script is

function trouble(text) {
    $("trouble").hidden = !text;
    $("trouble").textContent = text;
}

// ---- files: by their paths, which a model may shorten or begin elsewhere ----

function finder(files) {
    const paths = [...files.keys()];
    return (path) => {
        if (files.has(path)) return files.get(path);
        const parts = path.split("/");
        for (let k = 0; k < parts.length; ++k) {
            const end = parts.slice(k).join("/"), found = paths.find((p) => p === end || p.endsWith(`/${end}`));
            if (found) return files.get(found);
        }
        return undefined;
    };
}

const bytes = async (file) => new Uint8Array(await file.arrayBuffer());

// All files below a folder: by its handle, else by its entry, which Chromium does not read for pages that are files.
async function readHandle(folder, files, path) {
    for await (const [name, one] of folder.entries()) {
        if (one.kind === "directory") await readHandle(one, files, `${path}/${name}`);
        else files.set(`${path}/${name}`, await bytes(await one.getFile()));
    }
}

async function readEntry(folder, files, path) {
    const reader = folder.createReader();
    for (let list; (list = await new Promise((done, failed) => reader.readEntries(done, failed))).length > 0;)
        for (const one of list) {
            if (one.isDirectory) await readEntry(one, files, `${path}/${one.name}`);
            else files.set(`${path}/${one.name}`, await bytes(await new Promise((done, failed) => one.file(done, failed))));
        }
}

// What was dropped; items tell nothing any more once the event is over.
async function readDropped(items) {
    const dropped = [...items].filter((item) => item.kind === "file").map((item) => {
        const entry = item.webkitGetAsEntry?.(), folder = entry?.isDirectory;
        return { entry, folder, file: folder ? null : item.getAsFile(), handle: folder && item.getAsFileSystemHandle?.() };
    });
    const files = new Map();
    for (const { entry, folder, file, handle } of dropped) {
        if (!folder) files.set(file.name, await bytes(file));
        else if (handle) await readHandle(await handle, files, entry.name);
        else await readEntry(entry, files, entry.name);
    }
    return files;
}

async function readList(list) {
    const files = new Map();
    for (const file of list) files.set(file.webkitRelativePath || file.name, await bytes(file));
    return files;
}

// The first file that is a model; of those that cannot be read the last complaint is shown.
async function openFiles(files) {
    const found = [...files.keys()].filter((path) => kinds.test(path)).sort((a, b) => a.split("/").length - b.split("/").length);
    let complaint = "There is no file of a model: URDF, xacro, MJCF or SDF";
    for (const path of found) {
        try {
            await open(files.get(path), path, finder(files));
            return;
        } catch (error) {
            complaint = error.message;
        }
    }
    trouble(complaint);
}

// ---- one model after the other ----

async function open(text, name, files, options = {}) {
    const found = new Map(), model = library.read(text, { ...options, name, files: (path) => {
        const content = files?.(path);
        if (content !== undefined) found.set(path, content);
        return content;
    } });
    let data;
    try {
        data = await readData(model.page());
    } catch (error) {
        model.close();
        throw error;
    }
    running?.end();
    document.body.innerHTML = empty;
    let simulation;
    const viewer = await show(data, (now) => simulation?.frame(now), !isSoftware());
    const thread = new Worker(worker);
    thread.postMessage({ name: "open", args: [module, text, { ...options, name, files: found }] });
    simulation = new Simulation(model, viewer, thread);
    const hand = new Hand(viewer, simulation), parameters = new Parameters($("parameters"), model, simulation);
    running = { viewer, simulation, end: () => (hand.end(), simulation.end(), viewer.close()) };
    simulation.changed = () => {
        simulation.model.info.bodies.forEach(({ massless, mass }, k) => Object.assign(data.bodies[k], { massless, mass }));
        viewer.drawing.weigh();
        viewer.tree.list();
        viewer.paint();
        showCounts(data);
        $("report").replaceChildren();
        showReport($("report"), simulation.report());
    };
    frameOfPage();
    $("play").addEventListener("click", (event) => (event.stopImmediatePropagation(), simulation.play(!simulation.playing)), true);
    $("video").hidden = true;
    Object.assign(viewer, { play: (on) => simulation.play(on), reset: () => (simulation.reset(), parameters.reset(), viewer.stage.goHome()) });
    window.mbsrank.live = { simulation, parameters, hand };
}

// What the page has beside that of `mbsrank view`.
function frameOfPage() {
    const title = $("counts"), file = element("input", { type: "file", multiple: true, hidden: true, id: "file" });
    const button = element("button", { textContent: "open", title: "A model, or drop one with its files on the page" });
    button.addEventListener("click", () => file.click());
    file.addEventListener("change", async () => openFiles(await readList(file.files)));
    const choice = element("select", { id: "example", ariaLabel: "Examples" }, element("option", { textContent: "examples" }),
                           ...Object.keys(texts).map((name) => element("option", { value: name, textContent: name })));
    choice.addEventListener("change", () => open(texts[choice.value], choice.value));
    title.after(choice, button, file);
    $("player").style.display = "";
    $("slider").style.display = "none";
    if (!$("rate")) $("time").after(element("span", { id: "rate", className: "note" }));
}

function listen() {
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", async (event) => {
        event.preventDefault();
        try {
            await openFiles(await readDropped(event.dataTransfer.items));
        } catch (error) {
            trouble(error.message);
        }
    });
}

async function start() {
    const packed = $("module").textContent, given = $("data"), aside = document.querySelector("aside");
    aside.prepend(element("details", { open: true }, element("summary", { textContent: "Parameters" }),
                          element("div", { id: "parameters" })));
    texts = JSON.parse($("examples").textContent);
    worker = URL.createObjectURL(new Blob([$("worker").textContent], { type: "text/javascript" }));
    for (const script of document.querySelectorAll("body > script")) script.remove();
    empty = document.body.innerHTML;
    module = await WebAssembly.compile(await bytesOf(packed));
    library = await load(module);
    listen();
    frameOfPage();
    const first = Object.keys(texts)[0];
    try {
        if (given) {
            const { name, options, files } = JSON.parse(given.textContent), all = new Map();
            for (const [path, text] of Object.entries(files)) all.set(path, await bytesOf(text));
            await open(all.get(name), name === "-" ? "model" : name, finder(all), options);
        } else if (first) {
            await open(texts[first], first);
        }
    } catch (error) {
        trouble(error.message);
    }
}

start();
