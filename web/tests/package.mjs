// The npm package against the library in C: the same numbers in one evaluation, the same steps in a run; failures;
// memory that comes back.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node package.mjs PACKAGE PROJECT TWIN PROGRAM
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, project, twin, program] = process.argv.slice(2), long = process.env.MBSR_TEST_LONG;
const { load, Library, MbsrankError } = await import(pathToFileURL(join(folder, "mbsrank.js")));
const mb = await load(), models = join(project, "examples", "models");
const text = (name) => readFileSync(join(models, name), "utf8");
const files = readdirSync(models).filter((name) => /[.](xml|urdf|sdf)$/.test(name));

const near = (ours, theirs, what, tolerance = 1e-10) => {
    assert.equal(ours.length, theirs.length, what);
    const size = Math.max(1, ...theirs.map(Math.abs));
    ours.forEach((x, k) => assert.ok(Math.abs(x - theirs[k]) <= tolerance * size, `${what}[${k}]: ${x}, in C ${theirs[k]}`));
};

// A state that is not that of the file, where coordinates are not parts of quaternions.
function stateOf(model) {
    const q = model.start().q, some = (seed) => Float64Array.from({ length: model.nu }, (_, k) => Math.sin(seed + 1.7 * k));
    for (const joint of model.info.joints)
        if (joint.type === "hinge" || joint.type === "slide") q[joint.q] += 0.02 * Math.cos(3 * joint.q);
    return { q, u: some(1), udot: some(2), tau: some(3) };
}

const isAlike = (ours, theirs) => Math.abs(ours - theirs) <= Math.max(1, 0.02 * theirs);

// Steps of runs from five starts that differ by rounding: where closures are redundant these alone differ by 3 %.
function countSteps(model, end, name) {
    return [0, 1, 2, 3, 4].map((k) => {
        const q = model.start().q.map((x, i) => x + 1e-13 * k * Math.sin(i)), run = model.simulate({ q, rtol: 1e-8, atol: 1e-8 }).to(1);
        near(run.q, end, `${name}: q at the end`, 1e-6);
        const { steps } = run.stats;
        run.close();
        return steps;
    });
}

// Modes that swing as the program finds them by LAPACK; of about zero frequency are those of rounding.
function compareModes(model, name, ...options) {
    const said = execFileSync(program, ["modes", "--as-drawn", "--json", join(models, name), ...options], { stdio: ["ignore", "pipe", "ignore"] });
    const swings = ({ real, imaginary }) => imaginary > 1e-5 * Math.hypot(real, imaginary) && imaginary > 1e-6;
    const theirs = JSON.parse(said).modes.filter(swings), ours = model.modes(), of = (list, key) => Array.from(list, (mode) => mode[key]);
    near(of(ours, "frequency"), of(theirs, "frequency"), `${name}: frequencies`, 1e-9);
    near(of(ours, "damping"), of(theirs, "damping"), `${name}: damping`, 1e-9);
    return ours.length;
}

function compare(name) {
    const model = mb.read(text(name), { name, contacts: false }), { nq, nu } = model, { q, u, udot, tau } = stateOf(model);
    const input = [q, u, udot, tau].map((list) => list.join(" ")).join("\n");
    const numbers = execFileSync(twin, [join(models, name)], { input }).toString().trim().split("\n").map(Number);
    const next = (count) => numbers.splice(0, count), status = next(1)[0], accelerations = next(nu);
    if (status === 0) near(model.forwardDynamics(q, u, tau), accelerations, `${name}: u'`);
    else assert.throws(() => model.forwardDynamics(q, u, tau), { status: "MBSR_UNDETERMINED" });
    near(model.inverseDynamics(q, u, udot), next(nu), `${name}: forces`);
    near(model.massMatrix(q), next(nu * nu), `${name}: M`);
    const { kinetic, potential } = model.energy(q, u);
    near([kinetic, potential], next(2), `${name}: energies`);
    const steps = next(1)[0], end = next(nq), counts = countSteps(model, end, name);
    assert.ok(counts.some((n) => isAlike(n, steps)), `${name}: ${counts} steps, in C ${steps}`);
    compareModes(model, name, "--no-contacts");
    model.close();
    const touching = mb.read(text(name), { name });
    if (name !== "hills.xml") compareModes(touching, name); // its picture is not among the texts
    touching.close();
    return status;
}

const statuses = files.map(compare);
assert.ok(statuses.includes(0) && statuses.some((status) => status > 0), "models of both kinds");

// ---- many states at once ----

const link = (inner) => `<body pos="0 0 -1"><joint axis="0 1 0"/><geom type="capsule" size=".05 .4"/>${inner}</body>`;
const chain = `<mujoco><worldbody>${link(link(link("")))}</worldbody></mujoco>`;

{
    const model = mb.read(chain);
    const q = [0.1, 0.2, 0.3], u = [1, 0, 2], tau = [1, 2, 3], one = model.forwardDynamics(q, u, tau);
    near(model.batch([0, 0, 0, ...q], [0, 0, 0, ...u], [0, 0, 0, ...tau]).subarray(3), one, "many states", 1e-13);
    assert.throws(() => model.batch([...q, 0], [...u, 0]), /q has 4 numbers, 6 are expected/);
    assert.throws(() => model.batch(), /q has no numbers, 3 are expected/);
    assert.throws(() => model.batch([0, 0, 0, NaN, 0, 0], [0, 0, 0, 0, 0, 0]), /state 1/);
    model.close();
}

// ---- with shapes that touch, as the program runs them ----

{
    const name = "gripper.xml", model = mb.read(text(name), { name }), run = model.simulate().to(0.5);
    const said = execFileSync(program, ["run", "--json", "--quiet", "--t-end", "0.5", "-o", "/dev/null", join(models, name)],
                              { stdio: ["ignore", "pipe", "ignore"] });
    const { steps } = JSON.parse(said);
    assert.ok(isAlike(run.stats.steps, steps), `${name}: ${run.stats.steps} steps, in C ${steps}`);
    run.close();
    model.close();
}

// ---- what a model tells, parameters, steps of fixed size, pulling ----

{
    const name = "quarter_car.xml", model = mb.read(text(name), { name }), { q, u } = model.start();
    assert.deepEqual(model.info.bodies.map((b) => b.name), ["wheel", "mount", "body"]);
    assert.deepEqual(model.ranks(q, u).map((r) => r.rank), [1, 0, 1]);
    assert.equal(model.report().damped, 1);
    assert.match(model.reportText(), /1 damped/);
    const mass = model.parameters.find((p) => p.name === "bodies.body.mass");
    assert.equal(mass.value, 300);
    assert.equal(mass.unit, "kg");
    const none = model.with({ "bodies.wheel.mass": 0 });
    assert.deepEqual(none.info.bodies.map((b) => b.mass), [0, 0, 300]);
    assert.deepEqual(none.info.bodies.map((b) => b.massless), [false, true, false], "it has moments of inertia");
    assert.deepEqual(none.ranks(q, u).map((r) => r.rank), [0, 0, 1]);
    assert.equal(model.ranks(q, u)[0].rank, 1, "the model stays as it is");
    const run = model.simulate({ rtol: 1e-9, atol: 1e-9 }), times = [0.25, 0.5], seen = [...run.states(times)];
    assert.deepEqual(seen.map((s) => s.t), times);
    const steps = model.stepper({ h: 1e-3 }).step(500);
    near(Array.from(steps.q), Array.from(seen[1].q), "steps of fixed size", 1e-5);
    near(Array.from(model.poses(run.q)), Array.from(run.poses()), "poses", 1e-12);
    // its weight and 3 kN up: at rest it hangs on the spring of the hand
    const point = [0, 0, 0], at = Array.from(model.poses(q).subarray(24 + 9, 36)), stiffness = 1e5;
    const pulled = model.stepper({ h: 1e-2, pull: { body: 2, point, at, stiffness, damping: 1e4 } });
    pulled.drag([at[0], at[1], at[2] + 0.1]);
    pulled.step(400);
    assert.ok(Math.abs(pulled.u[2]) < 1e-3, `it rests: ${pulled.u}`);
    const height = pulled.poses()[24 + 11] - at[2];
    assert.ok(height > 0.05 && height < 0.1, `it has been lifted: ${height}`);
    assert.throws(() => steps.drag(at), /nothing is pulled/);
    assert.equal(JSON.parse(model.page(q, u)).bodies.length, 3);
    const [slow, fast] = model.modes(q, u), light = model.with({ "bodies.wheel.mass": 1e-4 }).modes();
    assert.ok(slow.frequency > 1 && slow.frequency < 1.5 && fast.frequency > 10 && fast.damping > 0.1);
    for (const modes of [light, none.modes()]) assert.ok(modes.length === 1 && Math.abs(modes[0].frequency - slow.frequency) < 0.01);
    model.close(); // what moves keeps it
    steps.step();
    run.to(0.6);
    for (const one of [run, steps, pulled, none]) one.close();
    assert.throws(() => run.to(1), /this Run is closed/);
    assert.throws(() => model.energy(q, u), /this Model is closed/);
    const many = mb.read(`<mujoco><worldbody>${"<body><freejoint/><geom size='.1'/></body>".repeat(40)}</worldbody></mujoco>`, { contacts: false });
    assert.throws(() => many.modes(), { status: "MBSR_ERR_VALUE" });
    many.close();
}

// ---- what moves in the page that runs (src/program/viewer/runner.js) ----

{
    const { Runner, lengths } = await import(pathToFileURL(join(project, "src", "program", "viewer", "runner.js")));
    const name = "quarter_car.xml", runner = new Runner(mb.read(text(name), { name })), home = runner.given.start();
    const clock = performance.now;
    let now = 0, tick = 0;
    performance.now = () => (now += tick);
    assert.throws(() => runner.advance(0.1, 1), "it has not begun");
    runner.begin(home);
    runner.advance(0.03, 1);
    assert.equal(Math.round(240 * runner.state.t), 7);
    runner.advance(0.3, 2);
    assert.equal(Math.round(240 * runner.state.t), 31, "no more than 0.1 s is caught up with");
    // a step that is refused: on from there by shorter ones, for good
    const { t } = runner.state, refuse = () => (runner.stepper.step = () => { throw new Error("refused"); });
    refuse();
    runner.advance(0.03, 1);
    assert.deepEqual([runner.length, runner.longest, runner.state.t], [0, 0, t]);
    runner.advance(0.03, 1);
    assert.equal(Math.round(480 * (runner.state.t - t)), 14);
    refuse();
    assert.throws(() => runner.advance(0.03, 1), /refused/);
    runner.longest = lengths.length - 1;
    // longer steps where they take too long, shorter ones after two seconds with time to spare, none longer while it is pulled
    const keep = (ms, count, length) => {
        tick = ms;
        for (let k = 0; k < 10 * count; ++k) runner.advance(0.051, 1);
        assert.equal(runner.length, length);
    };
    runner.begin(home);
    while (!runner.advance(0.051, 1)); // half a second is over
    keep(40, 2, 2);
    keep(0.01, 3, 2);
    keep(0.01, 1, 1);
    keep(0.01, 8, 1);
    keep(40, 1, 2);
    runner.grab({ body: 2, point: [0, 0, 0], at: [0, 0, 1], stiffness: 1e4, damping: 100 });
    keep(40, 4, 2);
    runner.drag([0, 0, 1.2]);
    assert.deepEqual(runner.pull.at, [0, 0, 1.2]);
    runner.grab();
    assert.equal(runner.pull, undefined);
    runner.exchange({ "bodies.wheel.mass": 0 }, runner.state, home);
    assert.equal(runner.model.info.bodies[0].mass, 0);
    assert.throws(() => runner.exchange({ "bodies.wheel.mass": -1 }, runner.state, home), /wheel/);
    assert.ok(runner.state.t > 0, "a refused model leaves the one that runs");
    performance.now = clock;
}

// ---- other files, and what is refused ----

{
    const mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    const source = '<mujoco><compiler meshdir="meshes"/><asset><mesh name="t" file="t.obj"/></asset><worldbody><body>' +
                   '<freejoint/><geom type="mesh" mesh="t"/></body></worldbody></mujoco>';
    const model = mb.read(source, { name: "models/one.xml", files: { "models/meshes/t.obj": mesh } });
    near([model.info.mass], [1000 / 6], "the mass of a mesh", 1e-6);
    assert.deepEqual(model.info.missing, []);
    model.close();
    const wrong = (call, pattern, status) => assert.throws(call, (error) => {
        assert.ok(error instanceof MbsrankError, error.stack);
        assert.match(error.message, pattern);
        if (status) assert.equal(error.status, status);
        return true;
    });
    wrong(() => mb.read("<robot", { name: "x.urdf" }), /x[.]urdf:1/);
    wrong(() => mb.read(source, { gravity: 1 }), /no option 'gravity'/);
    wrong(() => mb.read(text("arm.urdf"), { start: "home" }), /has no key 'home'/);
    wrong(() => mb.read(text("arm.urdf"), { set: { "bodies.x.mass": 1 } }), /no parameter bodies[.]x[.]mass/);
    const arm = mb.read(text("arm.urdf"), { name: "arm.urdf" }), { q, u } = arm.start();
    wrong(() => arm.forwardDynamics(q.subarray(1), u), /forwardDynamics: q has 6 numbers, 7 are expected/);
    wrong(() => arm.forwardDynamics(q, u, null, new Float32Array(7)), /Float64Array of 7/);
    wrong(() => arm.forwardDynamics(q.map(() => NaN), u), /./, "MBSR_NOT_FINITE");
    wrong(() => arm.with({ "bodies.arm.mass": 1 }), /there is no parameter 'bodies[.]arm[.]mass'/, "MBSR_ERR_ID");
    wrong(() => arm.with({ "bodies.fore.mass": -1 }), /fore/);
    wrong(() => arm.forwardDynamics(), /q has no numbers, 7 are expected/);
    wrong(() => arm.forwardDynamics(q), /u has 0 numbers, 7 are expected/);
    wrong(() => arm.simulate({ rtoll: 1 }), /no option 'rtoll'/);
    wrong(() => arm.stepper({ hh: 1 }), /no option 'hh'/);
    wrong(() => arm.stepper().step(-1), /the count is -1/);
    wrong(() => arm.stepper({ pull: { body: 0, point: [0, 0, 0], at: [0, 0, 0], stiffness: 1, damping: 1 } }).drag([1]), /target has 1/);
    const run = arm.simulate().to(0.1);
    wrong(() => run.to(0.05), /behind the present time/);
    assert.equal(run.to(0.2).t, 0.2, "it goes on");
    run.close();
    wrong(() => arm.simulate({ rtol: -1 }), /rtol/, "MBSR_ERR_VALUE");
    wrong(() => arm.stepper({ h: 0 }), /h/, "MBSR_ERR_VALUE");
    arm.close();
    arm.close();
    const calls = [() => arm.modes(q, u), () => arm.poses(q), () => arm.batch(q, u), () => arm.ranks(q, u), () => arm.report(q, u),
                   () => arm.stepper({ pull: { point: [0, 0, 0], at: [0, 0, 0] } }), () => arm.simulate({ q, u })];
    for (const call of calls) wrong(call, /this Model is closed/);
}

// ---- what the documents show ----

for (const page of ["docs/javascript.md", "web/README.md"]) {
    const source = readFileSync(join(project, page), "utf8"), blocks = [...source.matchAll(/```js\n([^]*?)```/g)];
    const code = blocks.map((block) => block[1].replace(/^import .*$/gm, "")).join("\n");
    const call = new (async () => {}).constructor("load", "text", "chainText", "console", code);
    await call(load, text("quarter_car.xml"), chain, { log: () => {} });
}

// ---- memory ----

{
    const count = long ? 100000 : 500, source = text("quarter_car.xml"), own = new Library(await WebAssembly.compile(
        readFileSync(join(folder, "mbsrank.wasm"))));
    const once = (k) => {
        const model = own.read(source), { q, u } = model.start(), other = model.with({ "bodies.wheel.mass": 1 });
        other.inverseDynamics(q, u, u);
        other.close();
        if (k % 20 === 0) model.simulate().close();
        assert.throws(() => own.read("<robot"));
        model.close();
    };
    for (let k = 0; k < 20; ++k) once(k);
    const before = own.bytes;
    for (let k = 0; k < count; ++k) once(k);
    assert.equal(own.bytes, before, "memory has grown");
}
