// Surfaces as src/program/surface.c packs them, and normals for them.
// SPDX-License-Identifier: BSD-3-Clause
const crease = Math.cos((40 * Math.PI) / 180); // faces that meet at larger angles have an edge between them
const most = 64; // faces at a vertex that are looked at

// Positions of vertices, three numbers each, and the vertices of triangles.
export function unpack(bytes, { vertices, triangles, low, high }) {
    const position = new Float32Array(3 * vertices), index = new Uint32Array(3 * triangles);
    for (let axis = 0; axis < 3; ++axis) {
        const lower = 2 * axis * vertices, upper = lower + vertices, step = (high[axis] - low[axis]) / 65535;
        for (let k = 0, place = 0; k < vertices; ++k) {
            const folded = bytes[lower + k] | (bytes[upper + k] << 8);
            place = (place + ((folded >> 1) ^ -(folded & 1))) & 0xffff;
            position[3 * k + axis] = low[axis] + place * step;
        }
    }
    for (let k = 0, at = 6 * vertices, next = 0; k < index.length; ++k) {
        let step = 0, shift = 0, byte;
        do {
            byte = bytes[at++];
            step |= (byte & 127) << shift;
            shift += 7;
        } while (byte & 128);
        index[k] = next - step;
        if (step === 0) ++next;
    }
    return { position, index };
}

// Normals of faces, as long as the faces are large, and of length 1.
function faceNormals(position, index) {
    const large = new Float32Array(index.length), unit = new Float32Array(index.length);
    for (let k = 0; k < index.length; k += 3) {
        const a = 3 * index[k], b = 3 * index[k + 1], c = 3 * index[k + 2];
        const x = position[a], y = position[a + 1], z = position[a + 2];
        const ux = position[b] - x, uy = position[b + 1] - y, uz = position[b + 2] - z;
        const vx = position[c] - x, vy = position[c + 1] - y, vz = position[c + 2] - z;
        large[k] = uy * vz - uz * vy;
        large[k + 1] = uz * vx - ux * vz;
        large[k + 2] = ux * vy - uy * vx;
        const length = Math.hypot(large[k], large[k + 1], large[k + 2]) || 1;
        for (let l = 0; l < 3; ++l) unit[k + l] = large[k + l] / length;
    }
    return { large, unit };
}

// The corners at each vertex: those from first[v] to first[v + 1].
function cornersAt(vertices, index) {
    const first = new Uint32Array(vertices + 1), corners = new Uint32Array(index.length);
    for (const v of index) ++first[v + 1];
    for (let v = 0; v < vertices; ++v) first[v + 1] += first[v];
    const next = first.slice();
    index.forEach((v, corner) => (corners[next[v]++] = corner));
    return { first, corners };
}

// Vertices apart where faces meet at an edge: each corner gets the mean normal of the faces at its vertex that are
// nearly in its own plane, and corners of one normal share a vertex.
export function withNormals({ position, index }) {
    const vertices = position.length / 3, { large, unit } = faceNormals(position, index);
    const { first, corners } = cornersAt(vertices, index), out = new Uint32Array(index.length);
    const from = [], normal = [], n = [0, 0, 0];
    const meanNormal = (v, face) => {
        n[0] = n[1] = n[2] = 0;
        for (let k = first[v]; k < first[v + 1]; ++k) {
            const other = corners[k] - (corners[k] % 3);
            const dot = unit[face] * unit[other] + unit[face + 1] * unit[other + 1] + unit[face + 2] * unit[other + 2];
            if (other !== face && (dot < crease || first[v + 1] - first[v] > most)) continue;
            for (let l = 0; l < 3; ++l) n[l] += large[other + l];
        }
        const length = Math.hypot(n[0], n[1], n[2]) || 1;
        for (let l = 0; l < 3; ++l) n[l] /= length;
    };
    for (let v = 0; v < vertices; ++v) {
        const begin = from.length;
        for (let k = first[v]; k < first[v + 1]; ++k) {
            meanNormal(v, corners[k] - (corners[k] % 3));
            let at = begin;
            while (at < from.length &&
                   n[0] * normal[3 * at] + n[1] * normal[3 * at + 1] + n[2] * normal[3 * at + 2] < 0.9999) ++at;
            if (at === from.length) {
                from.push(v);
                normal.push(n[0], n[1], n[2]);
            }
            out[corners[k]] = at;
        }
    }
    const moved = new Float32Array(3 * from.length);
    from.forEach((v, k) => moved.set(position.subarray(3 * v, 3 * v + 3), 3 * k));
    return { position: moved, normal: new Float32Array(normal), index: out };
}
