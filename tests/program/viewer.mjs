// Pages of `mbsrank view` in headless Chromium: they open without errors, show something, and their slider moves
// the bodies to where the run says.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node viewer.mjs PROGRAM PROJECT_DIR CHROMIUM WITH_RUN (1 or 0) [PICTURES]
// PICTURES: a folder for the screenshot that docs/ shows. Skipped (77) where the program has no bundle.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { Browser } from "./browser.mjs";

const [, , program, project, chromium, withRun, pictures] = process.argv;
const models = join(project, "examples", "models"), work = mkdtempSync(join(tmpdir(), "mbsrank-view-"));
let failures = 0;

function expect(good, text) {
    if (good) return;
    console.log(`FAILED: ${text}`);
    ++failures;
}

const mbsrank = (...args) => execFileSync(program, args, { stdio: ["ignore", "pipe", "ignore"], maxBuffer: 1e9 });

// Columns by name.
function readRun(path) {
    const [head, ...lines] = readFileSync(path, "utf8").trim().split("\n").map((line) => line.split(","));
    return Object.fromEntries(head.map((name, k) => [name, lines.map((line) => Number(line[k]))]));
}

const frames = "new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)))";

// Moves the slider as a hand does.
const slideTo = (t) => `(async () => {
    const slider = document.getElementById("slider");
    slider.value = ${t};
    slider.dispatchEvent(new Event("input"));
    await ${frames};
    return mbsrank.times.length;
})()`;

// Makes and opens the page of a model, with a run of it.
async function show(browser, model, scheme, ...options) {
    const page = join(work, "page.html"), csv = join(work, "run.csv");
    const run = withRun === "1" && options.length > 0;
    const path = resolve(models, model);
    if (run) mbsrank("run", path, "--quiet", "-o", csv, ...options);
    mbsrank("view", path, ...(run ? [csv] : []), "-o", page);
    await browser.open(page, scheme);
    const pixels = await browser.ask("mbsrank.pixels()");
    expect(pixels > 2000, `${model}: only ${pixels} pixels of the first frame show something`);
    return run ? readRun(csv) : null;
}

// Origins of bodies in the page are those that the program has written; what is drawn follows.
async function checkPoses(browser, run, bodies) {
    const count = await browser.ask("mbsrank.times.length");
    expect(count === run.t.length, `${count} samples of ${run.t.length}`);
    for (const k of [0, 1, count >> 1, count - 1]) {
        await browser.ask(slideTo(run.t[k]));
        for (const name of bodies) {
            const { pose, drawn } = await browser.ask(
                `(() => { const k = mbsrank.bodies.indexOf("${name}");
                          return { pose: mbsrank.pose(k), drawn: mbsrank.drawn(k) }; })()`);
            for (let l = 0; l < 3; ++l) {
                const should = run[`${name}.pos.${"xyz"[l]}`][k];
                expect(Math.abs(pose[9 + l] - should) < 1e-6,
                    `${name} at t = ${run.t[k]}: ${"xyz"[l]} is ${pose[9 + l]}, must be ${should}`);
                let there = pose[9 + l];
                for (let j = 0; j < 3; ++j) there += pose[3 * j + l] * drawn.local[12 + j];
                expect(Math.abs(drawn.world[12 + l] - there) < 1e-6, `${name} is not drawn where it is`);
            }
        }
    }
}

// The tyre carries what moves above it: 36 and 300 kg, accelerations by differences of the rates.
async function checkReactions(browser, run) {
    const h = run.t[2] - run.t[1], most = 336 * 9.81;
    for (const k of [40, 250, 480]) {
        await browser.ask(slideTo(run.t[k]));
        const wheel = (run["tyre.rate"][k + 1] - run["tyre.rate"][k - 1]) / (2 * h);
        const body = ["tyre", "damper", "rubber"].reduce(
            (sum, j) => sum + (run[`${j}.rate`][k + 1] - run[`${j}.rate`][k - 1]) / (2 * h), 0);
        const should = 36 * wheel + 300 * body + most;
        const [, , force] = await browser.ask(`mbsrank.reaction(mbsrank.bodies.indexOf("wheel"))`);
        expect(Math.abs(force - should) < 2e-3 * most, `tyre at t = ${run.t[k]}: ${force} N, must be ${should} N`);
    }
}

async function checkControls(browser) {
    const before = await browser.ask("mbsrank.pixels()");
    await browser.ask(`document.getElementById("show-forces").click(), ${frames}`);
    const after = await browser.ask("mbsrank.pixels()");
    expect(after !== before, "forces are not drawn on demand");
    const [dark, light] = await browser.ask(`(() => {
        const ground = () => getComputedStyle(document.body).backgroundColor, was = ground();
        document.getElementById("theme").click();
        return [was, ground()];
    })()`);
    expect(dark !== light, `light and dark have the same ground, ${dark}`);
    const names = await browser.ask(`(() => {
        const view = document.getElementById("view"), found = new Set();
        for (let y = 20; y < view.clientHeight; y += 20)
            for (let x = 20; x < view.clientWidth; x += 20) {
                mbsrank.hover(x, y);
                const tip = document.getElementById("hover");
                if (!tip.hidden) found.add(tip.textContent.split("\\n")[0]);
            }
        return [...found];
    })()`);
    expect(names.includes("wheel") && names.includes("body"), `names under the pointer: ${names}`);
    await browser.ask("mbsrank.play(true)");
    await new Promise((next) => setTimeout(next, 300));
    await browser.ask(frames);
    const moved = await browser.ask(`Number(document.getElementById("slider").value)`);
    expect(moved > 0, "playing does not move the slider");
}

async function quarterCar(browser) {
    const bodies = ["wheel", "mount", "body"];
    const run = await show(browser, "quarter_car.xml", "dark", "--t-end", "0.5", "--step", "0.001", "--start", "pushed",
        "--rtol", "1e-8", "--atol", "1e-10", "--output", "state," + bodies.map((b) => `${b}.pos`).join(","));
    const report = await browser.ask(`document.getElementById("report").textContent`);
    expect(/damped, without mass1/.test(report), `the report says ${report}`);
    if (!run) return;
    await checkPoses(browser, run, bodies);
    await checkReactions(browser, run);
    await browser.ask(slideTo(0));
    await checkControls(browser);
    await browser.ask("mbsrank.play(false)");
    await checkFilm(browser, 0.5);
}

async function arm(browser) {
    const bodies = ["upper", "fore", "wrist_2", "hand", "right"];
    const run = await show(browser, "arm.urdf", "light", "--t-end", "4", "--step", "0.02", "--output",
        "state," + bodies.map((b) => `${b}.pos`).join(","));
    if (run) await checkPoses(browser, run, bodies);
    if (!pictures || !run) return;
    await browser.ask(`for (const id of ["show-forces", "show-frames"]) document.getElementById(id).click()`);
    await browser.ask(`mbsrank.pick(mbsrank.bodies.indexOf("hand"))`);
    await browser.ask(slideTo(0.44));
    await browser.picture(join(pictures, "viewer.png"));
}

// The picture that the README begins with: two loops, and bodies without mass; a hand turns it.
async function suspension(browser) {
    const run = await show(browser, "suspension.xml", "light", "--t-end", "2", "--output", "state",
        "--inputs", join(models, "steer.csv"));
    if (!run) return;
    const turned = 260;
    const mouse = (type, x, buttons) => browser.send("Input.dispatchMouseEvent",
        { type, x, y: 400, button: "left", buttons, clickCount: 1 });
    await mouse("mousePressed", 450, 1);
    for (let k = 1; k <= 10; ++k) await mouse("mouseMoved", 450 + turned * k / 10, 1);
    await mouse("mouseReleased", 450 + turned, 0);
    for (let k = 0; k < 2; ++k)
        await browser.send("Input.dispatchMouseEvent", { type: "mouseWheel", x: 450, y: 400, deltaX: 0, deltaY: -120 });
    await browser.ask(slideTo(0.6));
    await browser.picture(join(pictures, "suspension.png"));
}

// Pictures of docs/contact.md: what touches, with its forces.
async function touching(browser) {
    const pages = [["quadruped.xml", 0.8, ["--start", "standing", "--t-end", "1", "--step", "0.02"]],
        ["gripper.xml", 0.9, ["--t-end", "3", "--step", "0.05", "--inputs", join(models, "grip.csv")]],
        ["hills.xml", 0.5, ["--t-end", "0.5", "--step", "0.02", "--rtol", "1e-4", "--atol", "1e-4"]],
        ["marbles.xml", 1, ["--t-end", "1", "--step", "0.02", "--rtol", "1e-4", "--atol", "1e-4"]]];
    for (const [model, t, options] of pages) {
        const run = await show(browser, model, "light", ...options, "--output", "state");
        if (!run) return;
        await browser.ask(`document.getElementById("show-contacts").click()`);
        for (const id of ["shown", "joints-of", "bodies-of"]) await browser.ask(`document.getElementById("${id}").open = false`);
        await browser.ask(slideTo(t));
        await browser.picture(join(pictures, model.replace(".xml", "_page.png")));
    }
}

// A bob of 2 kg hangs by a closure: where it hooks in, the force is what moves the bob, and gravity beside.
async function hookedBob(browser) {
    const model = join(work, "bob.xml"), mass = 2;
    writeFileSync(model, `<mujoco><worldbody><body name="bob" pos="0.3 0 0"><freejoint name="f"/>
        <inertial pos="0 0 0" mass="${mass}" diaginertia="0.01 0.01 0.01"/><geom size="0.05"/></body></worldbody>
        <equality><connect name="hook" body1="bob" anchor="-0.3 0 0"/></equality></mujoco>`);
    const run = await show(browser, model, "light", "--t-end", "1", "--step", "0.001", "--rtol", "1e-8", "--atol", "1e-10",
        "--output", "state");
    const [loop] = await browser.ask("mbsrank.loops");
    expect(loop.name === "hook" && loop.body === 0, `the closure is ${JSON.stringify(loop)}`);
    const boxes = await browser.ask(`["loops", "turns"].map((name) => document.getElementById("show-" + name).disabled)`);
    expect(!boxes.includes(true), "forces of closures cannot be shown");
    if (run) await browser.ask(slideTo(run.t[500]));
    const before = await browser.ask("mbsrank.pixels()");
    await browser.ask(`document.getElementById("show-loops").click(), ${frames}`);
    expect((await browser.ask("mbsrank.pixels()")) !== before, "forces of closures are not drawn on demand");
    for (const k of run ? [100, 500, 900] : []) {
        await browser.ask(slideTo(run.t[k]));
        const [x, y, z, ...wrench] = await browser.ask("mbsrank.loop(0)");
        expect(Math.hypot(x, y, z) < 1e-5, `the hook is at ${x}, ${y}, ${z}`);
        ["x", "y", "z"].forEach((axis, l) => {
            const v = run[`f.rate.v${axis}`], a = (v[k + 1] - v[k - 1]) / (run.t[k + 1] - run.t[k - 1]);
            const should = mass * (a + (l === 2 ? 9.81 : 0));
            expect(Math.abs(wrench[l] - should) < 1e-3 * mass * 9.81, `hook at t = ${run.t[k]}: ${wrench[l]} N, must be ${should} N`);
            expect(Math.abs(wrench[3 + l]) < 1e-6, `hook at t = ${run.t[k]}: a moment of ${wrench[3 + l]} N m`);
        });
    }
}

// A plate of Collada in centimetres, red and half of it green.
const effect = (name, rgba) => `<effect id="${name}-effect"><profile_COMMON><technique sid="common"><lambert><diffuse>
    <color>${rgba}</color></diffuse></lambert></technique></profile_COMMON></effect>`;
const material = (name) => `<material id="${name}"><instance_effect url="#${name}-effect"/></material>`;
const triangle = (name, corners) => `<triangles material="${name}" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
    <p>${corners}</p></triangles>`;
const plate = `<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="cm" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="skin"><init_from>none.png</init_from></image></library_images>
<library_effects>${effect("red", "1 0 0 1")}${effect("green", "0 1 0 1")}</library_effects>
<library_materials>${material("red")}${material("green")}</library_materials>
<library_geometries><geometry id="g"><mesh>
    <source id="x"><float_array id="xa" count="12">0 0 0 10 0 0 10 20 0 0 20 0</float_array>
        <technique_common><accessor source="#xa" count="4" stride="3"><param name="X" type="float"/>
            <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#x"/></vertices>
    ${triangle("red", "0 1 2")}${triangle("green", "0 2 3")}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>0 0 5</translate>
    <instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="red" target="#red"/>
        <instance_material symbol="green" target="#green"/></technique_common></bind_material></instance_geometry>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>`;

// The plate, with a ball for contact, carries two fingers in the colour of a material: one mesh, once mirrored, and the
// second finger mimics the first.
const inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>';
const finger = (name, y, mimic) => `<link name="${name}">${inertial}<visual><geometry>
        <mesh filename="wedge.obj" scale="1 ${y > 0 ? 1 : -1} 1"/></geometry><material name="blue"/></visual></link>
    <joint name="${name}" type="prismatic"><parent link="palm"/><child link="${name}"/><origin xyz="0 ${y} 0"/>
        <axis xyz="0 1 0"/><limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>${mimic}</joint>`;
const painted = `<robot name="painted"><material name="blue"><color rgba="0 0 1 1"/></material>
    <link name="palm">${inertial}<visual><geometry><mesh filename="plate.dae"/></geometry></visual>
        <collision><geometry><sphere radius="0.3"/></geometry></collision></link>
    ${finger("left", 0.4, "")}${finger("right", -0.2, '<mimic joint="left" multiplier="-1"/>')}</robot>`;

const wedge = "v 0 0 0\nv 0.2 0 0\nv 0 0.1 0\nv 0 0 0.2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

const near = (a, b) => a.length === b.length && a.every((x, k) => Math.abs(x - b[k]) < 1e-5);

// Sliders without a run, which the finger that mimics follows; a click in the tree hides; another picks.
async function checkHands(browser) {
    const click = (what) => browser.ask(`${what}.click(), ${frames}`);
    const names = await browser.ask("mbsrank.sliders.map((s) => [s.name, s.low, s.high])");
    expect(JSON.stringify(names) === '[["left",-0.5,0.5],["right",-0.5,0.5]]', `sliders: ${JSON.stringify(names)}`);
    await browser.ask(`mbsrank.set("left", 0.25), ${frames}`);
    const [left, right] = await browser.ask("[mbsrank.pose(1), mbsrank.pose(2)]");
    expect(near(left.slice(9), [0, 0.65, 0]) && near(right.slice(9), [0, -0.45, 0]), `fingers at ${left}; ${right}`);
    await click(`document.querySelectorAll(".tree input")[0]`);
    expect((await browser.ask("mbsrank.colours(0)")).length === 0, "a body that is hidden is still drawn");
    await click(`document.querySelectorAll(".tree .name")[2]`);
    expect((await browser.ask("mbsrank.picked()")) === 2, "a click in the tree picks nothing");
    const before = await browser.ask("mbsrank.target()");
    await click(`document.getElementById("follow")`);
    await browser.ask(`mbsrank.set("left", -0.25), ${frames}`);
    const after = await browser.ask("mbsrank.target()");
    expect(near(after.map((x, k) => x - before[k]), [0, 0.5, 0]), `the camera went from ${before} to ${after}`);
    await browser.ask(`mbsrank.reset(), ${frames}`);
    const [target, pose, picked] = await browser.ask("[mbsrank.target(), mbsrank.pose(1), mbsrank.picked()]");
    expect(near(target, before) && near(pose.slice(9), [0, 0.4, 0]) && picked === -1, "reset is not as at first");
}

async function paintedRobot(browser) {
    writeFileSync(join(work, "plate.dae"), plate);
    writeFileSync(join(work, "wedge.obj"), wedge);
    const model = join(work, "painted.urdf");
    writeFileSync(model, painted);
    await show(browser, model, "light");
    const colours = await browser.ask("mbsrank.colours(0).concat(mbsrank.colours(1))");
    const should = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    expect(should.every((c, k) => near(c, colours[k])), `colours: ${JSON.stringify(colours)}`);
    const reach = await browser.ask("mbsrank.reach(0)");
    expect(near(reach, [0, 0, 0.05, 0.1, 0.2, 0.05]), `the plate reaches from ${reach.slice(0, 3)} to ${reach.slice(3)} m`);
    await checkHands(browser);
    const visual = await browser.ask("mbsrank.pixels()");
    await browser.ask(`document.getElementById("show-frames").click(), ${frames}`);
    expect((await browser.ask("mbsrank.pixels()")) !== visual, "frames are not drawn on demand");
    await browser.ask(`(() => {
        const sets = document.getElementById("sets");
        sets.value = 2;
        sets.dispatchEvent(new Event("change"));
    })()`);
    expect(near(await browser.ask("mbsrank.reach(0)"), [-0.3, -0.3, -0.3, 0.3, 0.3, 0.3]), "collision shapes are not shown");
}

async function robots(browser) {
    await arm(browser);
    await paintedRobot(browser);
}

// A video of the run as WebM, as long as the run.
async function checkFilm(browser, seconds) {
    const film = await browser.ask(`(async () => {
        const blob = await mbsrank.film(), video = document.createElement("video");
        if (!blob) return null;
        video.src = URL.createObjectURL(blob);
        await new Promise((next) => (video.onloadedmetadata = video.onerror = next));
        return { type: blob.type, seconds: video.duration, size: blob.size };
    })()`);
    if (!film) console.log("This browser makes no videos");
    else
        expect(film.type === "video/webm" && Math.abs(film.seconds - seconds) < 0.05 && film.size > 1000,
            `the video is ${JSON.stringify(film)}`);
}

// A tree of ten thousand links, every seventh without mass, that swing.
function writeTree(path, csv, count) {
    const lines = ["<robot name='tree'>", `<link name='l0'>${inertial}</link>`], head = ["t"];
    for (let k = 1; k < count; ++k) {
        lines.push(`<link name='l${k}'>${k % 7 ? inertial : ""}</link>`,
            `<joint name='j${k}' type='continuous'><parent link='l${(k - 1) >> 1}'/><child link='l${k}'/>`,
            `<origin xyz='${k % 2 ? 0.5 : -0.5} 0 1' rpy='0 0 ${k % 3}'/><axis xyz='0 1 0'/></joint>`);
        head.push(`j${k}`);
    }
    writeFileSync(path, lines.join("\n") + "</robot>");
    const rows = [0, 1, 2].map((t) => head.map((_, k) => (k ? 0.3 * Math.sin(t + k) : t)).join(","));
    writeFileSync(csv, [head.join(","), ...rows].join("\n"));
}

// C = A B, 3 x 3 by columns.
const times = (A, B) => [0, 1, 2, 3, 4, 5, 6, 7, 8].map((k) => {
    let sum = 0;
    for (let l = 0; l < 3; ++l) sum += A[3 * l + (k % 3)] * B[3 * Math.floor(k / 3) + l];
    return sum;
});

// Each body of the tree stands on its parent as the file says: turned about z as drawn, then about y by q.
async function checkTree(browser, t) {
    await browser.ask(slideTo(t));
    for (const k of [1, 2, 5, 77, 4096, 9999]) {
        const [on, own] = await browser.ask(
            `["l${(k - 1) >> 1}", "l${k}"].map((name) => mbsrank.pose(mbsrank.bodies.indexOf(name)))`);
        const z = k % 3, q = 0.3 * Math.sin(t + k), offset = [k % 2 ? 0.5 : -0.5, 0, 1];
        const drawn = [Math.cos(z), Math.sin(z), 0, -Math.sin(z), Math.cos(z), 0, 0, 0, 1];
        const turned = [Math.cos(q), 0, -Math.sin(q), 0, 1, 0, Math.sin(q), 0, Math.cos(q)];
        const should = times(times(on.slice(0, 9), drawn), turned);
        for (let l = 0; l < 3; ++l)
            should.push(on[9 + l] + on[l] * offset[0] + on[3 + l] * offset[1] + on[6 + l] * offset[2]);
        const worst = Math.max(...should.map((x, l) => Math.abs(x - own[l])));
        expect(worst < 2e-6, `link ${k} at t = ${t} is off by ${worst}`);
    }
}

async function manyBodies(browser) {
    const [model, csv, page] = ["tree.urdf", "tree.csv", "tree.html"].map((name) => join(work, name));
    writeTree(model, csv, 10000);
    mbsrank("view", model, csv, "-o", page);
    await browser.open(page);
    await browser.ask(`(async () => { mbsrank.play(true); for (let k = 0; k < 3; ++k) await ${frames}; })()`);
    const { frames: count, least, median } = await browser.ask("mbsrank.script()");
    console.log(`10 000 bodies: ${least.toFixed(1)} ms of script in the shortest of ${count} frames, ` +
        `${median.toFixed(1)} ms in the middle one`);
    await browser.ask("mbsrank.play(false)");
    await checkTree(browser, 1);
    expect(least <= 8, `a frame of 10 000 bodies takes ${least} ms of script`);
}

async function inBrowser(test, width, height) {
    const browser = new Browser(chromium, width, height);
    try {
        await test(browser);
    } catch (error) {
        expect(false, `${test.name}: ${error.message}`);
    }
    expect(browser.messages.length === 0, `the console says: ${browser.messages.join("; ")}`);
    await browser.end();
}

try {
    mbsrank("view", join(models, "arm.urdf"), "-o", join(work, "first.html"));
} catch {
    console.log("Skipped: the viewer is not built (it needs npm)");
    process.exit(77);
}
await inBrowser(quarterCar, 900, 600);
await inBrowser(robots, pictures ? 1280 : 640, pictures ? 800 : 400);
if (pictures) await inBrowser(suspension, 1280, 800);
if (pictures) await inBrowser(touching, 1000, 560);
await inBrowser(hookedBob, 900, 600);
await inBrowser(manyBodies, 320, 240);
rmSync(work, { recursive: true });
process.exit(failures > 0 ? 1 : 0);
