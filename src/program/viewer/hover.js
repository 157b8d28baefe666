// What the pointer is on.
// SPDX-License-Identifier: BSD-3-Clause
import { Mesh, Raycaster, Sphere, Vector2, Vector3 } from "three";

// The body drawn at a place of the canvas (-1 .. 1), the ground excluded; -1: none. Spheres around the copies
// are tried before their triangles, so that ten thousand of them take little.
export function bodyAt(x, y, camera, batches) {
    const caster = new Raycaster(), sphere = new Sphere(), axis = new Vector3(), one = new Mesh();
    caster.setFromCamera(new Vector2(x, y), camera);
    let nearest = Infinity, body = -1;
    for (const { mesh, geometry, items } of batches) {
        const out = mesh.instanceMatrix.array;
        one.geometry = geometry;
        one.material = mesh.material;
        for (let k = 0; k < items.length; ++k) {
            if (items[k].body < 0) continue;
            one.matrixWorld.fromArray(out, 16 * k);
            sphere.center.copy(geometry.boundingSphere.center).applyMatrix4(one.matrixWorld);
            sphere.radius = 0;
            for (let c = 0; c < 3; ++c)
                sphere.radius = Math.max(sphere.radius, axis.fromArray(out, 16 * k + 4 * c).length());
            sphere.radius *= geometry.boundingSphere.radius;
            if (!caster.ray.intersectsSphere(sphere)) continue;
            const hits = [];
            one.raycast(caster, hits);
            for (const hit of hits) {
                if (hit.distance < nearest) [nearest, body] = [hit.distance, items[k].body];
            }
        }
    }
    return body;
}

const digits = (x) => (x === null ? "—" : Number(x.toPrecision(4)).toString());

export function describe(body, data, motion) {
    const b = data.bodies[body], p = 7 * body;
    const joints = b.joints.filter((name) => name);
    const lines = [b.name || `body ${body}`];
    if (joints.length > 0) lines.push(`joint ${joints.join(", ")}`);
    lines.push(b.massless ? "no mass" : `mass ${digits(b.mass)} kg`);
    lines.push(`at ${Array.from(motion.pose.subarray(p, p + 3), digits).join(", ")} m`);
    if (data.reactions) {
        const at = 6 * (motion.sample * data.bodies.length + body), r = data.reactions;
        lines.push(`joint force ${digits(Math.hypot(r[at], r[at + 1], r[at + 2]))} N`);
    }
    return lines.join("\n");
}
