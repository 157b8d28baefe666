// How large a model is.
// SPDX-License-Identifier: BSD-3-Clause
import { Box3, Vector3 } from "three";

// How thick links are is measured by `link`, which most of them are shorter than; arrows by the whole.
export function typicalLengths(data, meshes, motion) {
    const lengths = [], reach = new Box3(), at = new Vector3();
    const reached = (x, r) => {
        for (const s of [-r, r]) reach.expandByPoint(at.set(x[0] + s, x[1] + s, x[2] + s));
    };
    data.bodies.forEach((b, k) => {
        reached(motion.point(k, b.point), 0);
        const from = b.parent < 0 ? [0, 0, 0] : data.bodies[b.parent].point;
        const length = Math.hypot(...[0, 1, 2].map((l) => b.anchor[l] - from[l]));
        if (length > 0) lengths.push(length);
    });
    for (const s of data.shapes) {
        if (s.body < 0 || s.kind === "plane") continue;
        if (s.kind !== "mesh") reached(motion.point(s.body, s.at), Math.max(...s.size));
        for (const { geometry } of (s.kind === "mesh" && meshes.get(s.mesh)) || []) {
            if (!geometry.boundingSphere) geometry.computeBoundingSphere();
            reached(motion.point(s.body, s.at), geometry.boundingSphere.radius * Math.max(...s.size.map(Math.abs)));
        }
    }
    for (let k = 0; data.loopForces && k < 9 * data.loops.length; k += 9)
        reached(data.loopForces.subarray(k, k + 3), 0);
    const all = reach.isEmpty() ? 1 : reach.min.distanceTo(reach.max) || 1;
    lengths.sort((a, b) => a - b);
    const most = lengths.length > 0 ? lengths[Math.floor(0.8 * lengths.length)] : all;
    return { link: Math.min(0.4 * all, Math.max(all / 60, most)), whole: all };
}
