// MuJoCo on the cases of bench_contact: lines of the same CSV.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node contact_mujoco.mjs (in a folder with node_modules/@mujoco/mujoco, its WebAssembly of one thread)
import { createRequire } from "node:module";
import { join } from "node:path";
import { cwd, cpuUsage } from "node:process";
import { pathToFileURL } from "node:url";

const require = createRequire(join(cwd(), "package.json"));
const mujoco = await (await import(pathToFileURL(require.resolve("@mujoco/mujoco")).href)).default();
const samples = 1000;

// Squared errors at 1000 times, but where there is none (null); `before` is called ahead of each step.
function run(name, setting, xml, dt, end, error, before = () => {}) {
    const model = mujoco.MjModel.from_xml_string(xml), data = new mujoco.MjData(model);
    const steps = Math.round(end / dt), every = Math.max(1, Math.round(steps / samples));
    let sum = 0, count = 0;
    mujoco.mj_forward(model, data);
    const began = cpuUsage();
    for (let k = 1; k <= steps; ++k) {
        before(data);
        mujoco.mj_step(model, data);
        if (k % every) continue;
        const now = error(model, data);
        if (now === null) continue;
        sum += now;
        ++count;
    }
    const used = cpuUsage(began), cost = (used.user + used.system) * 1e-6;
    console.log(`${name},mujoco,${setting} ${dt},${(sum / count).toPrecision(3)},${cost.toPrecision(3)},${end},${steps}`);
    data.delete();
    model.delete();
}

const option = (dt, more = "") =>
    `<option timestep="${dt}" gravity="0 0 -9.81" integrator="implicitfast" cone="elliptic" tolerance="1e-12" ${more}/>`;

// ---- a slab under 25 balls is pulled ----

function rolling(name, angle, dt, solref) {
    const way = [Math.cos(angle), Math.sin(angle)], a = (150 - 0.4 * 35 * 9.81) / (10 + (25 * 2) / 7);
    let balls = "";
    for (let k = 0; k < 25; ++k)
        balls += `<body pos="${2 * Math.floor(k / 5) - 4} ${2 * (k % 5) - 4} 1.5"><freejoint/>
            <geom size="0.5" mass="1" friction="0.8 0 0"/></body>`;
    const xml = `<mujoco>${option(dt, 'impratio="100"')}<default><geom condim="3" friction="0.4 0 0" solref="${solref} 1"/>
        </default><worldbody><geom type="plane" size="99 99 1"/>
        <body pos="0 0 0.5"><freejoint/><geom type="box" size="10 10 0.5" mass="10"/></body>${balls}</worldbody></mujoco>`;
    const error = (model, data) => {
        let sum = 0;
        for (let l = 0; l < 3; ++l) {
            const v = a * data.time * (way[l] ?? 0);
            sum += (data.qvel[l] - v) ** 2 + (data.qvel[6 + l] - (2 / 7) * v) ** 2;
        }
        return sum;
    };
    run(name, `solref ${solref}`, xml, dt, 4, error, (data) => {
        data.qfrc_applied[0] = 150 * way[0];
        data.qfrc_applied[1] = 150 * way[1];
    });
}

// ---- 49 balls fall by 5 m without loss; the energy of contacts is not known, so balls count in the air ----

function bouncing(dt, stiffness) {
    let balls = "";
    for (let k = 0; k < 49; ++k)
        balls += `<body pos="${2 * Math.floor(k / 7)} ${2 * (k % 7)} 5"><freejoint/><geom size="0.1" mass="10"/></body>`;
    const xml = `<mujoco>${option(dt).replace("/>", '><flag energy="enable"/></option>')}
        <default><geom condim="1" solref="${-stiffness} 0"/></default>
        <worldbody><geom type="plane" size="99 99 1"/>${balls}</worldbody></mujoco>`;
    const start = 49 * 10 * 9.81 * 5;
    run("bouncing", `stiffness ${stiffness}`, xml, dt, 20, (model, data) => {
        return data.ncon > 0 ? null : (data.energy[0] + data.energy[1] - start) ** 2;
    });
}

// ---- 216 balls fall by 1 m with loss of all; squares of depths. (Without loss: some always touch, with unknown energy) ----

function dull(dt, solref) {
    const side = 6, count = side ** 3, radius = 0.1;
    let balls = "", seed = 42;
    const shift = () => ((seed = (1103515245 * seed + 12345) % 2147483648) / 2147483648) * 1e-3;
    for (let k = 0; k < count; ++k) {
        const at = [k % side, Math.floor(k / side) % side, Math.floor(k / side / side)].map((n) => 0.21 * n + shift());
        balls += `<body pos="${at[0]} ${at[1]} ${1.101 + at[2]}"><freejoint/><geom size="${radius}" mass="10"/></body>`;
    }
    const xml = `<mujoco>${option(dt)}<size memory="200M"/><default><geom condim="1" solref="${solref} 1"/></default>
        <worldbody><geom type="plane" size="99 99 1"/>${balls}</worldbody></mujoco>`;
    run("dull_balls_216", `solref ${solref}`, xml, dt, 2, (model, data) => {
        const q = Array.from(data.qpos);
        let sum = 0;
        for (let k = 0; k < count; ++k) {
            const x = q[7 * k], y = q[7 * k + 1], z = q[7 * k + 2];
            sum += Math.max(0, radius - z) ** 2;
            for (let l = 0; l < k; ++l) {
                const square = (x - q[7 * l]) ** 2 + (y - q[7 * l + 1]) ** 2 + (z - q[7 * l + 2]) ** 2;
                if (square < 4 * radius ** 2) sum += (2 * radius - Math.sqrt(square)) ** 2;
            }
        }
        return sum;
    });
}

for (const [name, angle] of [["rolling_y", Math.PI / 2], ["rolling_xy", Math.PI / 3]]) {
    rolling(name, angle, 0.001, 0.002);
    rolling(name, angle, 0.0002, 0.0004);
}
bouncing(0.001, 1e5);
bouncing(0.0001, 1e7);
dull(0.001, 0.002);
dull(0.0002, 0.0004);
