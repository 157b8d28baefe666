// The page that runs models, in headless Chromium: files are dropped on it, the mouse pulls bodies and moves sliders,
// masses become zero, others are opened; a hundred bodies take less than real time.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node page.mjs PAGE PROJECT CHROMIUM [FOLDER]    FOLDER: pictures are kept there
import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [page, project, chromium, folder] = process.argv.slice(2);
const { Browser } = await import(pathToFileURL(join(project, "tests", "program", "browser.mjs")));
const browser = new Browser(chromium), work = mkdtempSync(join(tmpdir(), "mbsrank-drop-"));

async function until(expression) {
    for (let k = 0; k < 600; ++k) {
        if (await browser.ask(expression)) return;
        await new Promise((next) => setTimeout(next, 100));
    }
    throw new Error(`it does not become true: ${expression}`);
}

const live = "window.mbsrank.live", keep = async (name) => folder && browser.picture(join(folder, `${name}.png`));
const mouse = (type, [x, y], buttons) =>
    browser.send("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons, clickCount: 1 });

// A place of the window where a body is drawn that can be pulled.
const place = () => browser.ask(`(() => {
    const { left, top, width, height } = document.getElementById("view").getBoundingClientRect(), { viewer } = ${live}.hand;
    for (let y = 20; y < height; y += 6)
        for (let x = 230; x < width; x += 6)
            if (viewer.hitAt(x, y).body > 0 && viewer.hitAt(x + 4, y + 4).body > 0) return [x + left, y + top];
    return null;
})()`);

// Files from outside, dropped in the middle of the page.
async function drop(...files) {
    await browser.ask(`window.mbsrank.old = true`);
    const data = { items: [], files, dragOperationsMask: 1 };
    for (const type of ["dragEnter", "dragOver", "drop"]) await browser.send("Input.dispatchDragEvent", { type, x: 400, y: 300, data });
}

// Takes a slider at the middle of its way and moves it to a part of that, beyond its ends too.
async function slide(selector, part) {
    const { left, top, width, height } = await browser.ask(`(() => {
        const slider = document.querySelector(${JSON.stringify(selector)});
        slider.scrollIntoView({ block: "center" });
        const { left, top, width, height } = slider.getBoundingClientRect();
        return { left, top, width, height };
    })()`);
    const y = top + height / 2, at = (x) => [left + x * width, y];
    await mouse("mousePressed", at(0.5), 1);
    for (const x of [0.5 + (part - 0.5) / 2, part]) await mouse("mouseMoved", at(x), 1);
    await mouse("mouseReleased", at(part), 0);
}

// A chain of rods on springs.
const rods = (count) => `<body pos="${count > 99 ? "0 0 20" : ".2 0 0"}" name="rod${count}"><joint name="hinge${count}" type="hinge" axis="0 1 0" ` +
    `stiffness="50" damping=".5"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".03"/>${count > 1 ? rods(count - 1) : ""}</body>`;

// Processor time of all threads of workers so far, s.
function ofWorkers() {
    let ticks = 0;
    for (const process of readdirSync("/proc").filter((name) => /^\d+$/.test(name)))
        try {
            for (const thread of readdirSync(`/proc/${process}/task`)) {
                const stat = readFileSync(`/proc/${process}/task/${thread}/stat`, "utf8"), [user, system] = stat.slice(stat.lastIndexOf(")") + 2).split(" ").slice(11, 13);
                if (stat.includes("(DedicatedWorker")) ticks += Number(user) + Number(system);
            }
        } catch {} // it has ended
    return ticks / 100;
}

// Frames and seconds of motion while the page plays for a while, processor time (ms) of its thread for each frame, and of it
// and the worker for a second of motion.
async function playFor(seconds) {
    const spent = async () => (await browser.send("Performance.getMetrics")).metrics.find(({ name }) => name === "TaskDuration").value;
    await browser.send("Performance.enable", { timeDomain: "threadTicks" });
    const stepped = ofWorkers(), before = await spent(), from = await browser.ask(`${live}.simulation.drawn`), [t, passed] = await browser.ask(`(async () => {
        const { simulation } = ${live}, start = performance.now(), { t } = simulation;
        await new Promise((next) => setTimeout(next, ${1000 * seconds}));
        return [simulation.t - t, performance.now() - start];
    })()`);
    const frames = await browser.ask(`${live}.simulation.drawn`) - from, steps = ofWorkers() - stepped, page = await spent() - before;
    return { rate: (1000 * frames) / passed, share: (1000 * t) / passed, cost: (1000 * page) / frames, steps, both: (1000 * (steps + page)) / t };
}

async function openExample(name) {
    await browser.ask(`${live} && (window.mbsrank.old = true), (() => {
        const choice = document.getElementById("example");
        choice.value = ${JSON.stringify(name)};
        choice.dispatchEvent(new Event("change"));
    })()`);
    await until(`!!${live} && !window.mbsrank.old`);
}

try {
    await browser.open(page);
    await until(`!!window.mbsrank && !!${live}`);

    // it falls, and time goes on
    await browser.ask(`document.getElementById("play").click()`);
    await until(`${live}.simulation.t > 0.1`);
    assert.ok(await browser.ask(`window.mbsrank.pixels() > 5000`));

    // pulled upwards it rises above where it was
    await openExample("quarter_car.xml");
    await until(`/steps of the driver; oscillations 1[.]17, 13[.]8 Hz/.test(document.getElementById("cost").textContent)`);
    const before = await browser.ask(`window.mbsrank.pose(2)[11]`), at = await place();
    await mouse("mousePressed", at, 1);
    await until(`${live}.hand.held !== null`);
    for (let k = 1; k <= 8; ++k) await mouse("mouseMoved", [at[0], at[1] - 8 * k], 1);
    await until(`window.mbsrank.pose(2)[11] > ${before} + 0.05`);
    await keep("pulled");
    await mouse("mouseReleased", [at[0], at[1] - 64], 0);
    assert.equal(await browser.ask(`${live}.hand.held`), null);

    // ten frames a second, and sixty: fewer pixels along each axis, and all of them again
    const widths = await browser.ask(`(() => {
        const { simulation } = ${live}, canvas = document.getElementById("view"), { viewer } = simulation;
        const after = (count, gap) => {
            for (let k = 0; k < count; ++k) simulation.frame((now += gap));
            return canvas.width;
        };
        let now = performance.now();
        Object.assign(simulation, { last: now, frames: { count: 0, whole: 0 }, playing: true });
        viewer.stage.sharpness = 1, viewer.fit();
        const all = [canvas.width, after(30, 100), after(2400, 16)];
        simulation.last = undefined, simulation.reset();
        return all;
    })()`);
    assert.equal(widths[1], Math.floor(widths[0] / 2));
    assert.equal(widths[2], widths[0]);

    // without the mass of the wheel one direction more is damped
    assert.equal(await browser.ask(`${live}.simulation.report().damped`), 1);
    await slide('input[aria-label="bodies.wheel.mass"]', -0.1);
    assert.equal(await browser.ask(`${live}.simulation.report().damped`), 2);
    assert.equal(await browser.ask(`document.getElementById("counts").textContent`), "3 bodies, 2 without mass");
    assert.equal(await browser.ask(`document.querySelectorAll("#tree .massless").length`), 2);
    await until(`/steps of the driver; oscillation 1[.]17 Hz/.test(document.getElementById("cost").textContent)`);
    await keep("without_mass");

    // a joint by hand
    await browser.ask(`${live}.simulation.play(false), window.mbsrank.set("tyre", 0.03)`);
    assert.equal(await browser.ask(`${live}.simulation.q[0]`), 0.03);
    await slide("#joints input[type=range]", 0.7);
    const { low, high } = await browser.ask(`window.mbsrank.sliders[0]`), moved = await browser.ask(`${live}.simulation.q[0]`);
    assert.ok(Math.abs(moved - (low + 0.7 * (high - low))) < 0.06 * (high - low), `${moved} in ${low} to ${high}`);

    // dropped files: a model, a folder with one, one that is wrong, one beside what it includes, a hundred bodies
    await drop(join(project, "examples", "models", "arm.urdf"));
    await until(`!window.mbsrank.old && document.getElementById("title").textContent === "arm"`);
    const put = (name, text) => (writeFileSync(join(work, name), text), join(work, name));
    mkdirSync(join(work, "folder", "models"), { recursive: true });
    put(join("folder", "models", "rod.xml"), `<mujoco model="in a folder"><worldbody>${rods(1)}</worldbody></mujoco>`);
    await drop(join(work, "folder"));
    await until(`!window.mbsrank.old && document.getElementById("title").textContent === "in a folder"`);
    await drop(put("wrong.xml", "<mujoco><worldbody><body><joint type='wheel'/></body></worldbody></mujoco>"));
    await until(`/wheel/.test(document.getElementById("trouble").textContent)`);
    await keep("refused");
    await drop(put("whole.xml", `<mujoco model="two files"><include file="part.xml"/></mujoco>`),
               put("part.xml", `<mujocoinclude><worldbody>${rods(3)}</worldbody></mujocoinclude>`));
    await until(`!window.mbsrank.old && document.getElementById("counts").textContent === "3 bodies"`);
    await drop(put("hundred.xml", `<mujoco model="hundred"><worldbody>${rods(100)}</worldbody></mujoco>`));
    await until(`!window.mbsrank.old && document.getElementById("counts").textContent === "100 bodies"`);
    await browser.ask(`document.getElementById("play").click()`);
    await until(`${live}.simulation.t > 0.3`);
    const { rate, share, cost, steps, both } = await playFor(1.5);
    console.log(`100 bodies: ${rate.toFixed(0)} frames a second, ${share.toFixed(2)} of real time, ${cost.toFixed(1)} ms of the page's thread a frame, ` +
        `with the worker ${both.toFixed(0)} ms for a second of motion`);
    await keep("hundred");
    assert.ok(rate > 0 && share > 0 && cost < 8, "a frame takes the page's thread too long");
    assert.ok(steps > 0 && (process.env.MBSR_WEB_UNOPTIMISED || both < 1000), "not in real time");

    // others
    for (const name of ["suspension.xml", "gripper.xml", "wiper.sdf"]) {
        await openExample(name);
        await browser.ask(`${live}.simulation.play(true)`);
        await until(`${live}.simulation.t > 0.05`);
        assert.equal(await browser.ask(`document.getElementById("trouble").textContent`), "");
        await keep(name);
    }
    assert.deepEqual(browser.messages, []);
} finally {
    await browser.end();
    rmSync(work, { recursive: true, force: true });
}
