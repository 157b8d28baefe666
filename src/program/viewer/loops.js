// Loops that stay closed while a joint is moved by hand: where bodies are tied, the other coordinates q follow by steps of
// least length of Newton's method,
//
//   q <- q - J^T (J J^T + e)^-1 g(q),
//
// g: gaps of ties (m; turns over `length`) and of couplings, J = dg/dq by differences, e: against rows that are dependent.
// SPDX-License-Identifier: BSD-3-Clause
import { vectorOf } from "./kinematics.js";

const steps = 20, step = 1e-6; // of Newton's method; of differences

// Of a rotation by columns, w first (Shepperd, 1978).
function quaternionOf(R) {
    const trace = R[0] + R[4] + R[8], four = [trace, R[0], R[4], R[8]], k = four.indexOf(Math.max(...four));
    const a = R[5] - R[7], b = R[6] - R[2], c = R[1] - R[3], d = R[1] + R[3], e = R[2] + R[6], f = R[5] + R[7];
    if (k === 0) return [1 + trace, a, b, c];
    if (k === 1) return [a, 1 + R[0] - R[4] - R[8], d, e];
    return k === 2 ? [b, d, 1 + R[4] - R[0] - R[8], f] : [c, e, f, 1 + R[8] - R[0] - R[4]];
}

// x of A x = b, A symmetric and positive definite, row by row; both are written over.
function solve(A, b) {
    const n = b.length;
    for (let k = 0; k < n; ++k)
        for (let i = k + 1; i < n; ++i) {
            const factor = A[i][k] / A[k][k];
            for (let j = k; j < n; ++j) A[i][j] -= factor * A[k][j];
            b[i] -= factor * b[k];
        }
    for (let k = n - 1; k >= 0; --k) {
        for (let j = k + 1; j < n; ++j) b[k] -= A[k][j] * b[j];
        b[k] /= A[k][k];
    }
    return b;
}

export class Loops {
    // length: of the model, m
    constructor(data, kinematics, length) {
        Object.assign(this, { data, kinematics, length });
        this.maps = new Float64Array(12 * (data.bodies.length + 1));
        this.maps.set([1, 0, 0, 0, 1, 0, 0, 0, 1], 12 * data.bodies.length);
        this.coordinates = this.#coordinates();
    }

    // Those of joints between the ends of ties, and of couplings.
    #coordinates() {
        const { bodies, ties, couplings } = this.data, all = new Set(couplings.flatMap((c) => c.q));
        for (const tie of ties) {
            const [a, b] = tie.body.map((k) => {
                const below = new Set();
                for (; k >= 0; k = bodies[k].parent) below.add(k);
                return below;
            });
            for (const k of [...a, ...b].filter((k) => a.has(k) !== b.has(k))) {
                const count = bodies[k].axes.length + (bodies[k].quaternion ? 4 : 0);
                for (let l = 0; l < count; ++l) all.add(bodies[k].q + l);
            }
        }
        return [...all];
    }

    get some() {
        return this.data.ties.length > 0 || this.data.couplings.some((c) => c.q.length !== 2);
    }

    // A frame or vector of an end of a tie in the world.
    #frame(tie, end) {
        const { maps, data } = this, f = tie.frames[end], out = [];
        const at = 12 * (tie.body[end] < 0 ? data.bodies.length : tie.body[end]);
        for (let c = 0; c < 4; ++c)
            for (let row = 0; row < 3; ++row) {
                const x = f.slice(3 * c, 3 * c + 3), origin = c === 0 ? maps[at + 9 + row] : 0;
                out.push(origin + maps[at + row] * x[0] + maps[at + 3 + row] * x[1] + maps[at + 6 + row] * x[2]);
            }
        return out;
    }

    gaps(q) {
        const g = [];
        this.kinematics.place(q, this.maps);
        for (const tie of this.data.ties) {
            const [a, b] = [this.#frame(tie, 0), this.#frame(tie, 1)];
            for (let l = 0; l < 3; ++l) g.push(a[l] - b[l]);
            if (tie.kind === "ball") continue;
            const turn = new Array(9).fill(0); // of b in a
            for (let c = 0; c < 3; ++c)
                for (let row = 0; row < 3; ++row)
                    for (let l = 0; l < 3; ++l) turn[3 * c + row] += a[3 + 3 * row + l] * b[3 + 3 * c + l];
            const s = quaternionOf(turn), size = Math.hypot(...s);
            g.push(...vectorOf(s.map((x) => x / size)).map((x) => 0.3 * this.length * x));
        }
        for (const c of this.data.couplings)
            g.push(c.coefficient.reduce((sum, f, k) => sum + f * q[c.q[k]], -c.offset));
        return g;
    }

    // The coordinates near q with closed loops, those of `held` as they are; null: there are none.
    close(start, held) {
        const q = start.slice(), free = this.coordinates.filter((k) => !held.includes(k));
        for (let k = 0; k < steps; ++k) {
            const g = this.gaps(q), off = Math.max(...g.map(Math.abs));
            if (off < 1e-7 * this.length) return q;
            const columns = free.map((l) => {
                const there = q.slice();
                there[l] += step;
                return this.gaps(there).map((x, row) => (x - g[row]) / step);
            });
            const square = g.map((_, i) => g.map((__, j) => columns.reduce((sum, c) => sum + c[i] * c[j], 0)));
            const small = 1e-9 * Math.max(...square.map((row, i) => row[i]), 1e-12);
            square.forEach((row, i) => (row[i] += small));
            const weights = solve(square, g);
            free.forEach((l, n) => (q[l] -= columns[n].reduce((sum, x, i) => sum + x * weights[i], 0)));
        }
        return null;
    }
}
