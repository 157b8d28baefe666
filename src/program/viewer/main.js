// The page of `mbsrank view`.
// SPDX-License-Identifier: BSD-3-Clause
import { Box3 } from "three";
import { Motion, jointArrows, loopArrows, readData } from "./data.js";
import { Drawing } from "./drawing.js";
import { Arrows, Axes } from "./extras.js";
import { bodyAt, describe } from "./hover.js";
import { Plots, element } from "./plots.js";
import { Stage, coloursOf, growBox } from "./stage.js";
import { showFindings, showReport } from "./tables.js";

const $ = (id) => document.getElementById(id);
const data = readData($("data").textContent);
const motion = new Motion(data);
const start = data.times[0], end = data.times.at(-1);
let playing = false, changed = true, moved = true;

// How thick links are is measured by `link`, which most of them are shorter than; arrows by the whole.
function typicalLengths() {
    const lengths = [], reach = new Box3(), at = { x: 0, y: 0, z: 0 };
    const reached = (x, r) => {
        for (const s of [-r, r]) {
            [at.x, at.y, at.z] = [x[0] + s, x[1] + s, x[2] + s];
            reach.expandByPoint(at);
        }
    };
    data.bodies.forEach((b, k) => {
        reached(motion.point(k, b.point), 0);
        const from = b.parent < 0 ? [0, 0, 0] : data.bodies[b.parent].point;
        const length = Math.hypot(...[0, 1, 2].map((l) => b.anchor[l] - from[l]));
        if (length > 0) lengths.push(length);
    });
    for (const s of data.shapes)
        if (s.kind !== "plane" && s.kind !== "mesh") reached(motion.point(s.body, s.at), Math.max(...s.size));
    for (let k = 0; data.loopForces && k < 9 * data.loops.length; k += 9)
        reached(data.loopForces.subarray(k, k + 3), 0);
    const all = reach.isEmpty() ? 1 : reach.min.distanceTo(reach.max) || 1;
    lengths.sort((a, b) => a - b);
    const most = lengths.length > 0 ? lengths[Math.floor(0.8 * lengths.length)] : all;
    return { link: Math.min(0.4 * all, Math.max(all / 60, most)), whole: all };
}

const { link: unitLength, whole } = typicalLengths();
const stage = new Stage($("view"));
const drawing = new Drawing(data, motion, unitLength);
const extras = { axes: new Axes(data, motion, unitLength) };
if (data.reactions) {
    const joints = jointArrows(data, motion), loops = loopArrows(data, motion), longest = 0.35 * whole;
    extras.forces = new Arrows(joints, motion, longest, false, "force");
    extras.moments = new Arrows(joints, motion, longest, true, "moment");
    if (loops.count > 0) {
        extras.loops = new Arrows(loops, motion, longest, false, "loop");
        extras.turns = new Arrows(loops, motion, longest, true, "turn");
    }
}
const batches = [...drawing.batches.values()];
const painted = [stage, drawing, ...Object.values(extras)];
stage.scene.add(drawing.group, ...Object.values(extras).map((e) => e.group));

function frameAll() {
    const box = new Box3(), times = 12;
    for (let k = 0; k <= times; ++k) {
        motion.go(start + (k / times) * (end - start));
        drawing.move();
        growBox(box, batches);
        if (end === start) break;
    }
    if (box.isEmpty()) box.set(box.min.set(-1, -1, -1), box.max.set(1, 1, 1));
    stage.frame(box, drawing.floor ?? box.min.z);
    motion.go(start);
}

// ---- what is around the picture ----

const seek = (t) => {
    motion.go(Math.min(end, Math.max(start, t)));
    $("slider").value = motion.time;
    $("time").textContent = `${motion.time.toFixed(3)} s`;
    moved = changed = true;
};
const plots = new Plots($("plots"), data, seek);

function addLegend() {
    const rows = [["body", "bodies"], ["massless", "bodies without mass"]];
    if (!data.bodies.some((b) => b.massless)) rows.pop();
    for (const [colour, text] of rows)
        $("legend").append(element("label", { className: "plain" }, swatch(colour), text));
    const extra = { axes: ["joint", "axes of joints"], forces: ["force", "forces of joints"],
                    moments: ["moment", "moments of joints"] };
    if (data.loops.length > 0)
        Object.assign(extra, { loops: ["loop", "forces of closures"], turns: ["turn", "moments of closures"] });
    for (const [name, [colour, text]] of Object.entries(extra)) {
        const box = element("input", { type: "checkbox", id: `show-${name}`, disabled: !extras[name] });
        const label = element("label", {}, box, swatch(colour), text);
        if (!extras[name]) {
            label.className = "off";
            label.title = data.without;
        }
        box.addEventListener("change", () => {
            extras[name].group.visible = box.checked;
            moved = changed = true;
        });
        $("legend").append(label);
    }
}

function swatch(name) {
    const node = element("span", { className: "swatch" });
    node.style.background = `var(--${name})`;
    return node;
}

function paint() {
    const colours = coloursOf(document.documentElement);
    for (const one of painted) one.paint(colours);
    plots.draw();
    changed = true;
}

function setTheme(dark) {
    document.documentElement.classList.toggle("dark", dark);
    paint();
}

function play(on) {
    playing = on && end > start;
    $("play").textContent = playing ? "❚❚" : "▶";
    if (playing && motion.time >= end) seek(start);
}

function listen() {
    const prefers = window.matchMedia("(prefers-color-scheme: dark)");
    prefers.addEventListener("change", (event) => setTheme(event.matches));
    $("theme").addEventListener("click", () => setTheme(!document.documentElement.classList.contains("dark")));
    $("play").addEventListener("click", () => play(!playing));
    $("slider").addEventListener("input", () => seek(Number($("slider").value)));
    document.addEventListener("keydown", (event) => {
        if (event.code !== "Space" || /INPUT|SELECT|BUTTON/.test(event.target.tagName)) return;
        event.preventDefault();
        play(!playing);
    });
    stage.controls.addEventListener("change", () => (changed = true));
    let last = 0;
    $("view").addEventListener("pointermove", (event) => {
        if (event.buttons || event.timeStamp - last < 60) return;
        last = event.timeStamp;
        hover(event.offsetX, event.offsetY);
    });
    $("view").addEventListener("pointerleave", () => ($("hover").hidden = true));
    new ResizeObserver(fit).observe($("stage"));
    return prefers.matches;
}

function fit() {
    stage.fit($("stage").clientWidth, $("stage").clientHeight);
    plots.draw();
    changed = true;
}

function hover(x, y) {
    const { clientWidth: w, clientHeight: h } = $("stage"), tip = $("hover");
    const body = bodyAt((2 * x) / w - 1, 1 - (2 * y) / h, stage.camera, batches);
    tip.hidden = body < 0;
    if (body < 0) return;
    tip.textContent = describe(body, data, motion);
    tip.style.left = `${Math.min(x + 14, w - tip.offsetWidth - 8)}px`;
    tip.style.top = `${Math.min(y + 14, h - tip.offsetHeight - 8)}px`;
}

// ---- frames ----

const script = []; // ms of the last frames

function frame(now) {
    const before = performance.now(), passed = (now - (frame.last ?? now)) / 1000;
    frame.last = now;
    if (playing) {
        const t = motion.time + passed * Number($("speed").value);
        seek(t > end ? start + ((t - start) % (end - start)) : t);
    }
    if (moved) {
        drawing.move();
        for (const one of Object.values(extras)) if (one.group.visible) one.move();
        plots.point(motion);
        moved = false;
    }
    stage.controls.update();
    if (changed) {
        changed = false;
        stage.draw();
        script.push(performance.now() - before);
        if (script.length > 200) script.shift();
    }
    requestAnimationFrame(frame);
}

// ---- start ----

document.title = `${data.title} – mbsrank`;
$("title").textContent = data.title;
const massless = data.bodies.filter((b) => b.massless).length;
$("counts").textContent = `${data.bodies.length} bodies` + (massless > 0 ? `, ${massless} without mass` : "");
Object.assign($("slider"), { min: start, max: end, value: start });
$("player").hidden = end === start;
if (end === start) $("player").style.display = "none";
showReport($("report"), data.report);
$("found").hidden = !showFindings($("findings"), data.findings);
if (drawing.trouble.length > 0) {
    $("trouble").hidden = false;
    $("trouble").textContent = drawing.trouble.join("; ");
}
addLegend();
fit();
frameAll();
const dark = listen();
setTheme(dark);
seek(start);
requestAnimationFrame(frame);

// For scripts, tests among them: what is drawn, and how long that took.
window.mbsrank = {
    bodies: data.bodies.map((b) => b.name),
    times: data.times,
    seek,
    play,
    setTheme,
    hover,
    // axes of the body by columns, then its origin, m
    pose: (body) => Array.from(motion.map.subarray(12 * body, 12 * body + 12)),
    // force and moment of its joint on it at the sample before, N and N m
    reaction: (body) => {
        const at = 6 * (motion.sample * data.bodies.length + body);
        return data.reactions && Array.from(data.reactions.subarray(at, at + 6));
    },
    // closures that act at a point, and of one at the sample before: where, force and moment on its body
    loops: data.loops,
    loop: (k) => {
        const at = 9 * (motion.sample * data.loops.length + k);
        return data.loopForces && Array.from(data.loopForces.subarray(at, at + 9));
    },
    // the first thing drawn of it: where in the body, and in the world (4 x 4, by columns)
    drawn: (body) => {
        const found = batches.flatMap((b) => b.items.map((item, k) => [b, item, k])).find(([, i]) => i.body === body);
        if (!found) return null;
        const [batch, item, k] = found, at = 16 * k;
        return { local: item.local.elements, world: Array.from(batch.mesh.instanceMatrix.array.slice(at, at + 16)) };
    },
    pixels: () => stage.pixels(),
    script: () => {
        const sorted = [...script].sort((a, b) => a - b);
        return { frames: sorted.length, least: sorted[0], median: sorted[sorted.length >> 1] };
    },
};
