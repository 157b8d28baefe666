// A model and its run in the page: what is around the picture, and who listens to whom.
// SPDX-License-Identifier: BSD-3-Clause
import { Box3 } from "three";
import { $, download } from "./dom.js";
import { addLegend } from "./legend.js";
import { readMesh } from "./meshes.js";
import { growBox } from "./stage.js";
import { showFindings, showReport } from "./tables.js";
import { Viewer } from "./viewer.js";

// Parts by name, and what is wrong with those that cannot be drawn.
async function readMeshes(data) {
    const meshes = new Map(), trouble = [];
    for (const [name, mesh] of Object.entries(data.meshes)) {
        try {
            meshes.set(name, await readMesh(mesh));
        } catch (error) {
            trouble.push(`mesh '${name}': ${error.message}`);
        }
    }
    return { meshes, trouble };
}

// ---- what is around the picture ----

export function showCounts(data) {
    const massless = data.bodies.filter((b) => b.massless).length;
    $("counts").textContent = `${data.bodies.length} bodies` + (massless > 0 ? `, ${massless} without mass` : "");
}

function fill(viewer, trouble) {
    const { data, start, end } = viewer;
    document.title = `${data.title} – mbsrank`;
    $("title").textContent = data.title;
    showCounts(data);
    Object.assign($("slider"), { min: start, max: end, value: start });
    if (end === start) {
        $("player").style.display = "none";
        $("video").disabled = true;
        $("video").title = "There is no run to film";
    }
    $("strips").hidden = data.columns.length === 0;
    $("joints-of").open = data.columns.length === 0;
    $("bodies-of").open = data.bodies.length <= 20;
    showReport($("report"), data.report);
    $("found").hidden = !showFindings($("findings"), data.findings);
    $("trouble").hidden = trouble.length === 0;
    $("trouble").textContent = trouble.join("; ");
    addLegend($("legend"), viewer);
    $("shown").open = $("stage").clientWidth > 700;
}

function listenToPointer(viewer) {
    let last = 0, down = null;
    const view = $("view");
    view.addEventListener("pointermove", (event) => {
        if (event.buttons || event.timeStamp - last < 60) return;
        last = event.timeStamp;
        viewer.hover(event.offsetX, event.offsetY);
    });
    view.addEventListener("pointerleave", () => ($("hover").hidden = true));
    view.addEventListener("pointerdown", (event) => (down = [event.offsetX, event.offsetY]));
    view.addEventListener("click", (event) => {
        const { offsetX: x, offsetY: y } = event;
        if (down && Math.hypot(x - down[0], y - down[1]) < 4) viewer.pick(viewer.bodyAt(x, y));
    });
}

async function savePicture(viewer) {
    download(await viewer.picture(), `${viewer.data.title}.png`);
}

async function saveVideo(viewer) {
    const button = $("video"), text = button.textContent;
    const video = await viewer.film((part) => (button.textContent = `■ ${Math.round(100 * part)} %`));
    if (viewer.filming) return;
    button.textContent = text;
    if (video) download(video, `${viewer.data.title}.webm`);
    else button.title = "This browser makes no videos";
}

// Until the signal `ended`.
function listen(viewer, signal) {
    const prefers = window.matchMedia("(prefers-color-scheme: dark)"), root = document.documentElement;
    prefers.addEventListener("change", (event) => viewer.setTheme(event.matches), { signal });
    $("theme").addEventListener("click", () => viewer.setTheme(!root.classList.contains("dark")));
    $("play").addEventListener("click", () => viewer.play(!viewer.playing));
    $("slider").addEventListener("input", () => viewer.seek(Number($("slider").value)));
    $("reset").addEventListener("click", () => viewer.reset());
    $("follow").addEventListener("change", () => viewer.follow($("follow").checked));
    $("picture").addEventListener("click", () => savePicture(viewer));
    $("video").addEventListener("click", () => saveVideo(viewer));
    $("panel").addEventListener("click", () => root.classList.toggle("alone"));
    document.addEventListener("keydown", (event) => {
        if (event.code !== "Space" || /INPUT|SELECT|BUTTON|SUMMARY/.test(event.target.tagName)) return;
        event.preventDefault();
        viewer.play(!viewer.playing);
    }, { signal });
    viewer.stage.controls.addEventListener("change", () => (viewer.changed = true));
    listenToPointer(viewer);
    const resized = new ResizeObserver(() => viewer.filming || viewer.fit());
    resized.observe($("stage"));
    signal.addEventListener("abort", () => resized.disconnect());
    return prefers.matches;
}

// ---- for scripts, tests among them: what is drawn, and how long that took ----

function scriptsFor(viewer) {
    const { data, motion, stage, drawing, batches, joints } = viewer;
    const items = batches.flatMap((b) => b.items.map((item, k) => [b, item, k]));
    const itemsOf = (body) => items.filter(([, item]) => item.body === body);
    return {
        bodies: data.bodies.map((b) => b.name),
        times: data.times,
        loops: data.loops,
        sliders: joints.sliders.map(({ name, low, high }) => ({ name, low, high })),
        seek: (t) => viewer.seek(t),
        play: (on) => viewer.play(on),
        setTheme: (dark) => viewer.setTheme(dark),
        hover: (x, y) => viewer.hover(x, y),
        pick: (body) => viewer.pick(body),
        picked: () => drawing.picked,
        showSets: (sets, among) => viewer.showSets(sets, among),
        reset: () => viewer.reset(),
        film: () => viewer.film(() => true),
        // the coordinate of that name by hand
        set: (name, x) => joints.setByName(name, x),
        // axes of the body by columns, then its origin, m
        pose: (body) => Array.from(motion.map.subarray(12 * body, 12 * body + 12)),
        // force and moment of its joint on it at the sample before, N and N m
        reaction: (body) => {
            const at = 6 * (motion.sample * data.bodies.length + body);
            return data.reactions && Array.from(data.reactions.subarray(at, at + 6));
        },
        // of a closure that acts at a point, at the sample before: where, force and moment on its body
        loop: (k) => {
            const at = 9 * (motion.sample * data.loops.length + k);
            return data.loopForces && Array.from(data.loopForces.subarray(at, at + 9));
        },
        // points of contact at the sample before: where, m, and force, N, each
        contacts: () => {
            const size = 6 * data.contacts, at = size * motion.sample;
            return data.contactForces ? Array.from(data.contactForces.subarray(at, at + size)) : [];
        },
        // colours of what is shown of a body, and the corners of the box around that
        colours: (body) => itemsOf(body).filter(([b, , k]) => b.isShown(k, motion)).map(([, item]) => item.colour),
        reach: (body) => {
            const box = new Box3();
            drawing.move();
            for (const [batch, , k] of itemsOf(body)) growBox(box, [batch], motion, k);
            return [...box.min.toArray(), ...box.max.toArray()];
        },
        // the first thing drawn of it: where in the body, and in the world (4 x 4, by columns)
        drawn: (body) => {
            const [found] = itemsOf(body);
            if (!found) return null;
            const [batch, item, k] = found, at = 16 * k;
            return { local: item.local.elements, world: Array.from(batch.mesh.instanceMatrix.array.slice(at, at + 16)) };
        },
        target: () => stage.controls.target.toArray(),
        pixels: () => stage.pixels(),
        script: () => {
            const sorted = [...viewer.script].sort((a, b) => a - b);
            return { frames: sorted.length, least: sorted[0], median: sorted[sorted.length >> 1] };
        },
    };
}

// Draws what `readData` has made, frame by frame, until viewer.close(); `before` is called at the beginning of each frame.
export async function show(data, before = () => {}, smooth = true) {
    const { meshes, trouble } = await readMeshes(data), ended = new AbortController();
    const viewer = new Viewer(data, meshes, smooth);
    fill(viewer, trouble);
    viewer.setTheme(listen(viewer, ended.signal));
    viewer.seek(viewer.start);
    window.mbsrank = scriptsFor(viewer);
    viewer.close = () => {
        ended.abort();
        viewer.stage.renderer.dispose();
    };
    const frame = (now) => {
        if (ended.signal.aborted) return;
        before(now);
        viewer.frame(now);
        requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
    return viewer;
}
