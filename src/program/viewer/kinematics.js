// Where bodies are at given joint coordinates: each stands on its predecessor by A, the axes of its joint one after the
// other, a quaternion, and the inverse of B (mbsr_joint_chain).
// SPDX-License-Identifier: BSD-3-Clause

// Maps of 12 numbers: axes by columns, then origin. C = A B, at places in arrays; C must be another one.
function multiply(A, a, B, b, C, c) {
    for (let column = 0; column < 4; ++column)
        for (let row = 0; row < 3; ++row) {
            let sum = column === 3 ? A[a + 9 + row] : 0;
            for (let l = 0; l < 3; ++l) sum += A[a + 3 * l + row] * B[b + 3 * column + l];
            C[c + 3 * column + row] = sum;
        }
}

// "A" of the data (origin first) as a map.
const mapOf = (frame) => [...frame.slice(3), ...frame.slice(0, 3)];

function inverse(m) {
    const out = new Array(12);
    for (let k = 0; k < 3; ++k) for (let l = 0; l < 3; ++l) out[3 * k + l] = m[3 * l + k];
    for (let k = 0; k < 3; ++k) out[9 + k] = -(m[3 * k] * m[9] + m[3 * k + 1] * m[10] + m[3 * k + 2] * m[11]);
    return out;
}

// w first, of any length but zero.
function turn(w, x, y, z) {
    const s = 2 / (w * w + x * x + y * y + z * z);
    return [1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y),
            s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x),
            s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y), 0, 0, 0];
}

function alongAxis({ kind, direction, pitch }, q) {
    const d = direction.map((x) => x / Math.hypot(...direction));
    const angle = kind === "slide" ? 0 : q, way = kind === "slide" ? q : kind === "screw" ? pitch * q : 0;
    const out = turn(Math.cos(angle / 2), ...d.map((x) => x * Math.sin(angle / 2)));
    for (let l = 0; l < 3; ++l) out[9 + l] = way * d[l];
    return out;
}

// A rotation vector, and the quaternion (w first) of one.
export function quaternionOf(v) {
    const angle = Math.hypot(...v), s = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
    return [Math.cos(angle / 2), s * v[0], s * v[1], s * v[2]];
}

export function vectorOf([w, x, y, z]) {
    const length = Math.hypot(x, y, z), angle = 2 * Math.atan2(length, Math.abs(w));
    const s = (w < 0 ? -1 : 1) * (length > 1e-9 ? angle / length : 2);
    return [s * x, s * y, s * z];
}

export class Kinematics {
    constructor(data) {
        this.data = data;
        this.A = data.bodies.map((b) => mapOf(b.A));
        this.back = data.bodies.map((b) => inverse(mapOf(b.B)));
        this.order = [];
        const carried = data.bodies.map(() => []), next = [];
        data.bodies.forEach((b, k) => (b.parent < 0 ? next : carried[b.parent]).push(k));
        while (next.length > 0) {
            const k = next.pop();
            this.order.push(k);
            next.push(...carried[k]);
        }
    }

    // Maps of all bodies (Motion.map) at the coordinates q.
    place(q, maps) {
        const { data, A, back } = this, ground = 12 * data.bodies.length;
        let here = new Array(12), there = new Array(12);
        for (const k of this.order) {
            const b = data.bodies[k], first = b.q + (b.quaternion ? 4 : 0);
            multiply(maps, b.parent < 0 ? ground : 12 * b.parent, A[k], 0, here, 0);
            const add = (step) => {
                multiply(here, 0, step, 0, there, 0);
                [here, there] = [there, here];
            };
            b.axes.forEach((axis, l) => add(alongAxis(axis, q[first + l])));
            if (b.quaternion) add(turn(q[b.q], q[b.q + 1], q[b.q + 2], q[b.q + 3]));
            multiply(here, 0, back[k], 0, maps, 12 * k);
        }
    }

    // What follows coordinate number `moved` by couplings of two, and what follows that; each coupling acts once.
    follow(q, moved) {
        const used = new Set(), next = [moved];
        while (next.length > 0) {
            const from = next.pop();
            for (const c of this.data.couplings) {
                const end = c.q.indexOf(from);
                if (end < 0 || c.q.length !== 2 || used.has(c)) continue;
                used.add(c);
                const to = c.q[1 - end];
                q[to] = (c.offset - c.coefficient[end] * q[from]) / c.coefficient[1 - end];
                next.push(to);
            }
        }
    }
}
