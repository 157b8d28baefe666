// What pages of `mbsrank view` hold, without a browser: surfaces come back to what they were and take little, joints put
// bodies where the library puts them.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node page.mjs PROGRAM PROJECT_DIR CONTACT (ON: the program has the component)
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [, , program, project, contact] = process.argv, work = mkdtempSync(join(tmpdir(), "mbsrank-page-"));
const part = (name) => import(pathToFileURL(join(project, "src", "program", "viewer", name)));
const { Motion, bytesOf, contactArrows, readData } = await part("data.js");
const { Kinematics, quaternionOf, vectorOf } = await part("kinematics.js");
const { Loops } = await part("loops.js");
const { unpack, withNormals } = await part("surface.js");
let failures = 0;

function expect(good, text) {
    if (good) return;
    console.log(`FAILED: ${text}`);
    ++failures;
}

writeFileSync(join(work, "bundle"), "<!--data-->");
const inWork = (name, text) => {
    writeFileSync(join(work, name), text);
    return join(work, name);
};

async function pageOf(...files) {
    const env = { ...process.env, MBSRANK_VIEWER: join(work, "bundle") };
    const page = execFileSync(program, ["view", ...files, "-o", "-"],
        { env, maxBuffer: 1e9, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
    return { size: page.length, data: await readData(page.slice(page.indexOf("{"), page.lastIndexOf("}") + 1)) };
}

const robotOf = (mesh) => inWork("robot.urdf", `<robot name="r"><link name="a"><visual><geometry>
    <mesh filename="${mesh}"/></geometry></visual></link></robot>`);

// ---- surfaces ----

// A torus of n times n quads as programs write OBJ, with normals that the page makes again.
function torus(n) {
    const lines = [], faces = [];
    for (let i = 0; i < n; ++i)
        for (let j = 0; j < n; ++j) {
            const a = (2 * Math.PI * i) / n, b = (2 * Math.PI * j) / n, r = 0.5 + 0.2 * Math.cos(b);
            const x = [r * Math.cos(a), r * Math.sin(a), 0.2 * Math.sin(b)];
            const normal = [Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)];
            lines.push(`v ${x.map((c) => c.toFixed(8)).join(" ")}`, `vn ${normal.map((c) => c.toFixed(6)).join(" ")}`);
            const at = (p, q) => 1 + n * (p % n) + (q % n);
            const corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.push(`f ${corners.map((c) => `${c}//${c}`).join(" ")}`);
        }
    return [...lines, ...faces].join("\n");
}

async function largeSurface() {
    const n = 120, obj = torus(n);
    inWork("torus.obj", obj);
    const { size, data } = await pageOf(robotOf("torus.obj")), mesh = data.meshes["torus.obj"];
    expect(mesh.vertices === n * n && mesh.triangles === 2 * n * n, `${mesh.vertices} vertices, ${mesh.triangles} triangles`);
    const most = mesh.surface[0] === "z" ? obj.length / 20 : obj.length / 5; // with zlib, without
    console.log(`${obj.length} bytes of OBJ are a page of ${size}`);
    expect(size < most, `a page of ${size} bytes for ${obj.length} bytes of OBJ`);
    const { position, normal } = withNormals(unpack(await bytesOf(mesh.surface), mesh));
    expect(position.length === 3 * n * n, "a smooth surface has edges");
    let off = 0, crooked = 0;
    for (let k = 0; k < position.length; k += 3) {
        const [x, y, z] = position.subarray(k, k + 3), ring = Math.hypot(x, y), out = ring - 0.5;
        off = Math.max(off, Math.abs(Math.hypot(out, z) - 0.2));
        const along = (normal[k] * x * out) / ring + (normal[k + 1] * y * out) / ring + normal[k + 2] * z;
        crooked = Math.max(crooked, 1 - along / 0.2);
    }
    expect(off < 1.4 / 65535, `points are ${off} m beside the torus`);
    expect(crooked < 1e-4, `normals are off by ${Math.acos(1 - crooked)} rad`);
}

// Corners and their order come back; triangles without area do not.
async function smallSurface() {
    const corners = [[0, 0, 0], [3, 0, 0], [0, 2, 0], [3, 2, 0], [3, 2, 1]];
    const faces = [[1, 2, 3], [2, 4, 3], [4, 4, 5], [5, 4, 2]];
    inWork("small.obj", [...corners.map((x) => `v ${x.join(" ")}`), ...faces.map((f) => `f ${f.join(" ")}`)].join("\n"));
    const { data } = await pageOf(robotOf("small.obj")), mesh = data.meshes["small.obj"];
    const surface = unpack(await bytesOf(mesh.surface), mesh);
    const should = [faces[0], faces[1], faces[3]].flat().map((k) => corners[k - 1]);
    expect(surface.index.length === should.length, `${surface.index.length} corners of ${should.length}`);
    should.forEach((x, k) => {
        const there = surface.position.subarray(3 * surface.index[k], 3 * surface.index[k] + 3);
        expect(x.every((c, l) => Math.abs(c - there[l]) < 1e-6), `corner ${k} is at ${there}, must be at ${x}`);
    });
    // the floor is one plane, on which the wall stands at an edge
    const { normal, index } = withNormals(surface), up = [...index].map((v) => Math.abs(normal[3 * v + 2]));
    expect(up.slice(0, 6).every((z) => z > 0.9999) && up.slice(6).every((z) => z < 1e-4), `normals: ${up}`);
}

// ---- joints ----

const joints = `<mujoco><worldbody>
    <body name="base" pos="0 0 1" euler="10 20 30"><freejoint name="free"/><geom size="0.1"/>
        <site name="eye" pos="0.1 0 0" euler="0 90 0"/>
        <body name="ball" pos="0.3 0 0"><joint name="ball" type="ball" pos="0 0 0.1"/><geom size="0.1"/>
            <body name="two" pos="0 0.2 0" euler="0 0 45"><joint name="h1" axis="1 2 0" pos="0 0 0.05"/>
                <joint name="h2" axis="0 1 1" pos="0 0 0.05"/><geom size="0.1"/>
                <body name="slide" pos="0 0 0.4"><joint name="s" type="slide" axis="1 1 1"/><geom size="0.1"/></body></body></body></body>
    </worldbody></mujoco>`;

// Maps of all bodies from coordinates are those of the poses that the library has computed.
async function checkPlaces(data) {
    const motion = new Motion(data), kinematics = new Kinematics(data), maps = new Float64Array(motion.map.length);
    maps.set(motion.map.subarray(12 * motion.bodies), 12 * motion.bodies); // the ground
    for (const t of data.times) {
        motion.go(t);
        kinematics.place(motion.coordinates(), maps);
        const worst = Math.max(...motion.map.map((x, k) => Math.abs(x - maps[k])));
        expect(worst < 2e-6, `${data.title} at t = ${t}: bodies are off by ${worst}`);
    }
    return kinematics;
}

async function jointsOfEveryKind() {
    const names = ["free.w", "free.x", "free.y", "free.z", "free.px", "free.py", "free.pz", "ball.w", "ball.x", "ball.y",
        "ball.z", "h1", "h2", "s"];
    const turn = (t) => quaternionOf([0.3 + t, -0.5, 0.2 * t]);
    const row = (t) => [t, ...turn(t), t, 2 * t, -t, ...turn(2 - t), 0.4 * t, -1.1 * t, 0.2 + t].join(",");
    const csv = inWork("run.csv", [["t", ...names].join(","), ...[0, 0.5, 1, 2].map(row)].join("\n"));
    const { data } = await pageOf(inWork("joints.xml", joints), csv);
    expect(data.times.length === 4 && data.nq === names.length, `${data.times.length} samples of ${data.nq} coordinates`);
    await checkPlaces(data);
    const [site] = data.sites;
    expect(site.name === "eye" && site.body === 0 && site.frame[0] === 0.1, `the site is ${JSON.stringify(site)}`);
}

async function mimickingJoints() {
    const { data } = await pageOf(join(project, "examples", "models", "arm.urdf"));
    const kinematics = await checkPlaces(data), q = new Float64Array(data.nq);
    expect(data.couplings.length > 0, "arm.urdf has no joint that mimics another");
    for (const { q: [a, b], coefficient, offset } of data.couplings) {
        q[b] = 0.017;
        kinematics.follow(q, b);
        expect(Math.abs(coefficient[0] * q[a] + coefficient[1] * q[b] - offset) < 1e-15, `coordinate ${a} is ${q[a]}`);
    }
}

// A crank of 0.2 m on a coupler of 0.5 m and a rocker of 0.4 m, 0.5 m away, whose end is tied to the ground; a wheel
// welded to the coupler, on two slides and a hinge of its own; a lid that is kept at 0.3 rad.
const linkage = `<mujoco><compiler angle="radian"/><worldbody>
    <body name="crank"><joint name="crank" axis="0 1 0"/><geom size="0.02"/>
        <body name="coupler" pos="0 0 0.2"><joint name="coupler" axis="0 1 0"/><geom size="0.02"/>
            <body name="rocker" pos="0.5 0 0.2"><joint name="rocker" axis="0 1 0"/><geom size="0.02"/></body></body></body>
    <body name="wheel" pos="0 0.1 0.2"><joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>
        <joint name="turn" axis="0 1 0"/><geom size="0.02"/></body>
    <body name="lid"><joint name="lid"/><geom size="0.02"/></body></worldbody>
    <equality><joint joint1="lid" polycoef="0.3 0 0 0 0"/><connect body1="rocker" anchor="0 0 -0.4"/><weld body1="coupler" body2="wheel"/></equality></mujoco>`;

async function loopsByHand() {
    const { data } = await pageOf(inWork("linkage.xml", linkage)), kinematics = await checkPlaces(data);
    const loops = new Loops(data, kinematics, 1), open = Float64Array.from(data.coordinates);
    expect(Math.max(...loops.gaps(open).map(Math.abs)) < 1e-6, `gaps as drawn: ${loops.gaps(open)}`);
    let q = open;
    q[6] = 0.5;
    for (let angle = 0; angle < 0.9; angle += 0.05) {
        q[0] = angle;
        q = loops.close(q, [0]);
        expect(q && q[0] === angle, `the crank at ${angle} is at ${q && q[0]}`);
        if (!q) return;
        // crank and rocker by their ends: |rocker's foot - coupler's end| = 0.4, |coupler| as drawn
        const [x, z] = [0.2 * Math.sin(q[0]), 0.2 * Math.cos(q[0])], turn = q[0] + q[1];
        const end = [x + 0.5 * Math.cos(turn) + 0.2 * Math.sin(turn), z - 0.5 * Math.sin(turn) + 0.2 * Math.cos(turn)];
        const rocker = Math.hypot(end[0] - 0.5, end[1]);
        expect(Math.abs(q[6] - 0.3) < 1e-6, `the lid is at ${q[6]}`);
        expect(Math.abs(rocker - 0.4) < 1e-6, `crank at ${angle}: the rocker is ${rocker} m long`);
        expect(Math.abs(q[5] - turn) < 1e-6 && Math.abs(q[3] - x) < 1e-6, `the wheel is at ${q.slice(3)}`);
    }
    const far = q.slice();
    far[3] = 5; // the wheel 5 m away
    expect(loops.close(far, [3]) === null, "a loop closes over 5 m");
}

// A level rod of 2 kg and 1 m on a hinge, its end held by a loop: half its weight, without a moment.
async function loopsAreArrows() {
    const { data } = await pageOf(inWork("rod.xml", `<mujoco><option gravity="0 0 -10"/><worldbody><body name="rod">
        <joint axis="0 1 0"/><inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.2 0.2"/></body></worldbody>
        <equality><connect body1="rod" anchor="1 0 0"/></equality></mujoco>`));
    const found = data.loopForces ? Array.from(data.loopForces) : [], wanted = [1, 0, 0, 0, 0, 10, 0, 0, 0];
    expect(found.length === 9 && wanted.every((x, k) => Math.abs(found[k] - x) < 1e-5), `the loop has ${found}, not ${wanted}`);
}

// A ball of 2 kg, drawn 1 mm deep in the floor: of both shapes 2 M / T^2 each, so M depth / T^2 between them.
async function contactsAreArrows() {
    const { data } = await pageOf(inWork("ball.xml", `<mujoco><worldbody><geom type="plane" size="1 1 1"/>
        <body pos="0.3 0 0.099"><freejoint/><geom size="0.1" mass="2" solref="0.1 1"/></body></worldbody></mujoco>`));
    const place = [0, 0, 0], arrows = contactArrows(data, new Motion(data));
    expect(data.contacts >= 1, "a ball in the floor touches nothing");
    arrows.tail(0, place);
    expect(Math.abs(place[0] - 0.3) < 1e-6 && Math.abs(place[2] + 0.0005) < 1e-6, `the point is at ${place}`);
    const k = 1 / (0.1 ** 2 / 4 + 0.02 ** 2 / 4), force = arrows.values[arrows.first + 2];
    expect(Math.abs(force - 0.001 * k) < 1e-3 * 0.001 * k, `the force is ${force}, not ${0.001 * k}`);
}

function rotationVectors() {
    for (const v of [[0, 0, 0], [1e-12, 0, 0], [0.3, -2, 1], [0, 0, 3.1]])
        for (const sign of [1, -1]) {
            const back = vectorOf(quaternionOf(v).map((x) => sign * x));
            expect(back.every((x, l) => Math.abs(x - v[l]) < 1e-12), `the turn ${v} comes back as ${back}`);
        }
}

for (const test of [largeSurface, smallSurface, jointsOfEveryKind, mimickingJoints, loopsByHand, loopsAreArrows,
    rotationVectors, ...(contact === "ON" ? [contactsAreArrows] : [])]) {
    try {
        await test();
    } catch (error) {
        expect(false, `${test.name}: ${error.stack}`);
    }
}
rmSync(work, { recursive: true });
process.exit(failures > 0 ? 1 : 0);
