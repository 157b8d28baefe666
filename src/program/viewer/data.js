// The data of the page, as src/program/page.c writes it, and the motion between its samples.
// SPDX-License-Identifier: BSD-3-Clause

// src/program/bytes.h: base64 behind a letter, 'z' where the bytes are deflated.
export async function bytesOf(text) {
    const binary = atob(text.slice(1)), bytes = new Uint8Array(binary.length);
    for (let k = 0; k < binary.length; ++k) bytes[k] = binary.charCodeAt(k);
    if (text[0] !== "z") return bytes;
    const inflated = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(inflated).arrayBuffer());
}

const floatsOf = async (text) => text && new Float32Array((await bytesOf(text)).buffer);

// "A", "B" and "frame": origin, then axes by columns; "anchor" and "point": where the joint is on the predecessor and
// on the body.
export async function readData(text) {
    const data = JSON.parse(text);
    for (const name of ["coordinates", "poses", "reactions", "loopForces", "contactForces"]) data[name] = await floatsOf(data[name]);
    for (const column of data.columns) column.values = await floatsOf(column.values);
    for (const b of data.bodies) {
        b.anchor = b.A.slice(0, 3);
        b.point = b.B.slice(0, 3);
        b.joints = [];
    }
    for (const j of data.joints) if (j.name) data.bodies[j.body].joints.push(j.name);
    data.nq = data.coordinates.length / data.times.length;
    return data;
}

// The sample at or before a time, and how far on from it the next one is, 0 .. 1.
export function placeAt(times, t) {
    let low = 0, high = times.length - 1;
    if (t >= times[high]) return { sample: high, part: 0 };
    while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (times[middle] <= t) low = middle;
        else high = middle;
    }
    return { sample: low, part: Math.max(0, (t - times[low]) / (times[high] - times[low])) };
}

// What joints exert on their bodies, as arrows: `values` has `stride` numbers for each of `count` in each sample,
// force and moment from `first` on; `tail` writes where the arrow begins.
export function jointArrows(data, motion) {
    return { count: data.bodies.length, values: data.reactions, stride: 6, first: 0,
             tail: (k, to) => motion.point(k, data.bodies[k].point, to) };
}

// What closures exert; between samples they are where they act on a straight line.
export function loopArrows(data, motion) {
    const count = data.loops.length, values = data.loopForces, stride = 9;
    const tail = (k, to) => {
        const at = stride * (count * motion.sample + k), next = motion.part > 0 ? at + stride * count : at;
        for (let l = 0; l < 3; ++l) to[l] = values[at + l] + motion.part * (values[next + l] - values[at + l]);
    };
    return { count, values, stride, first: 3, tail };
}

// What shapes exert where they touch: as many places in each sample as there are points at most, zeros where there are
// fewer.
export function contactArrows(data, motion) {
    const count = data.contacts, values = data.contactForces, stride = 6;
    const tail = (k, to) => {
        const at = stride * (count * motion.sample + k);
        for (let l = 0; l < 3; ++l) to[l] = values[at + l];
    };
    return { count, values, stride, first: 3, tail };
}

// Where all bodies are: affine maps by columns, 12 numbers each (axes, then origin), the ground behind the last body
// and behind that one a map to nothing, for what is hidden. At a time of the run, between samples by poses
// (origin, quaternion with w first), or by hand (kinematics.js). Nothing is allocated from time to time.
export class Motion {
    constructor(data) {
        this.data = data;
        this.bodies = data.bodies.length;
        this.byHand = false;
        this.pose = new Float32Array(7 * this.bodies);
        this.map = new Float64Array(12 * (this.bodies + 2));
        const ground = 12 * this.bodies;
        this.map[ground] = this.map[ground + 4] = this.map[ground + 8] = 1;
        this.go(data.times[0]);
    }

    go(t) {
        this.time = t;
        this.byHand = false;
        Object.assign(this, placeAt(this.data.times, t));
        this.#interpolate();
        this.#findMaps();
    }

    // The coordinates of the sample before.
    coordinates() {
        const { nq, coordinates } = this.data;
        return coordinates.slice(nq * this.sample, nq * (this.sample + 1));
    }

    // Where a map of a body (-1: the ground) begins.
    place(body) {
        return 12 * (body < 0 ? this.bodies : body);
    }

    get nowhere() {
        return 12 * (this.bodies + 1);
    }

    // Quaternions: the nearer of +-q, and length 1 again.
    #interpolate() {
        const { pose, part, bodies } = this, from = this.data.poses, at = 7 * bodies * this.sample;
        if (part === 0) {
            pose.set(from.subarray(at, at + 7 * bodies));
            return;
        }
        for (let k = 0, a = at, b = at + 7 * bodies; k < 7 * bodies; k += 7, a += 7, b += 7) {
            for (let l = 0; l < 3; ++l) pose[k + l] = from[a + l] + part * (from[b + l] - from[a + l]);
            let dot = 0, square = 0;
            for (let l = 3; l < 7; ++l) dot += from[a + l] * from[b + l];
            const to = dot < 0 ? -part : part;
            for (let l = 3; l < 7; ++l) {
                pose[k + l] = (1 - part) * from[a + l] + to * from[b + l];
                square += pose[k + l] * pose[k + l];
            }
            const length = Math.sqrt(square) || 1;
            for (let l = 3; l < 7; ++l) pose[k + l] /= length;
        }
    }

    #findMaps() {
        const { pose, map, bodies } = this;
        for (let k = 0, p = 0, m = 0; k < bodies; ++k, p += 7, m += 12) {
            const w = pose[p + 3], x = pose[p + 4], y = pose[p + 5], z = pose[p + 6];
            map[m] = 1 - 2 * (y * y + z * z);
            map[m + 1] = 2 * (x * y + w * z);
            map[m + 2] = 2 * (x * z - w * y);
            map[m + 3] = 2 * (x * y - w * z);
            map[m + 4] = 1 - 2 * (x * x + z * z);
            map[m + 5] = 2 * (y * z + w * x);
            map[m + 6] = 2 * (x * z + w * y);
            map[m + 7] = 2 * (y * z - w * x);
            map[m + 8] = 1 - 2 * (x * x + y * y);
            map[m + 9] = pose[p];
            map[m + 10] = pose[p + 1];
            map[m + 11] = pose[p + 2];
        }
    }

    // A point of a body (-1: the ground) in the world, and a direction.
    point(body, x, to = [0, 0, 0]) {
        const m = this.place(body), map = this.map;
        for (let l = 0; l < 3; ++l)
            to[l] = map[m + l] * x[0] + map[m + 3 + l] * x[1] + map[m + 6 + l] * x[2] + map[m + 9 + l];
        return to;
    }

    direction(body, x, to = [0, 0, 0]) {
        const m = this.place(body), map = this.map;
        for (let l = 0; l < 3; ++l) to[l] = map[m + l] * x[0] + map[m + 3 + l] * x[1] + map[m + 6 + l] * x[2];
        return to;
    }

    // The centre of all masses; NaN: there is none.
    centre(to = [0, 0, 0]) {
        const at = [0, 0, 0];
        let mass = 0;
        to.fill(0);
        this.data.bodies.forEach((b, k) => {
            if (!(b.mass > 0)) return;
            this.point(k, b.centre, at);
            for (let l = 0; l < 3; ++l) to[l] += b.mass * at[l];
            mass += b.mass;
        });
        for (let l = 0; l < 3; ++l) to[l] /= mass;
        return to;
    }
}
