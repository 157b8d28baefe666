// What the pointer is on.
// SPDX-License-Identifier: BSD-3-Clause
import { DoubleSide, Mesh, MeshBasicMaterial, Raycaster, Sphere, Vector2, Vector3 } from "three";

// The body drawn at a place of the canvas (-1 .. 1), the ground excluded (-1: none), and the point of it there. Spheres
// around the copies are tried before their triangles, so that ten thousand of them take little.
export function hitAt(x, y, camera, batches, motion) {
    const caster = new Raycaster(), sphere = new Sphere(), axis = new Vector3(), one = new Mesh();
    caster.setFromCamera(new Vector2(x, y), camera);
    let nearest = Infinity, body = -1, point = null;
    one.material = new MeshBasicMaterial({ side: DoubleSide });
    for (const batch of batches) {
        const { mesh, geometry, items } = batch, out = mesh.instanceMatrix.array;
        one.geometry = geometry;
        for (let k = 0; k < items.length; ++k) {
            if (items[k].body < 0 || !batch.isShown(k, motion)) continue;
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
                if (hit.distance < nearest) [nearest, body, point] = [hit.distance, items[k].body, hit.point];
            }
        }
    }
    return { body, point };
}

// The site nearest to a place of the canvas (-1 .. 1) and nearer than `reach` (of its width and height); null: none.
export function siteAt(x, y, reach, camera, sites, motion) {
    const at = new Vector3();
    let found = null, nearest = 1;
    for (const site of sites) {
        at.fromArray(motion.point(site.body, site.frame)).project(camera);
        const off = Math.hypot((at.x - x) / reach[0], (at.y - y) / reach[1]);
        if (off < nearest && at.z < 1) [nearest, found] = [off, site];
    }
    return found;
}

const digits = (x) => (x === null ? "—" : Number(Math.abs(x) < 1e-9 ? 0 : x.toPrecision(4)).toString());

export function describe(body, data, motion) {
    const b = data.bodies[body], at = Array.from(motion.map.subarray(12 * body + 9, 12 * body + 12));
    const lines = [b.name || `body ${body}`];
    if (b.joints.length > 0) lines.push(`joint ${b.joints.join(", ")}`);
    lines.push(b.massless ? "no mass" : `mass ${digits(b.mass)} kg`);
    lines.push(`at ${at.map(digits).join(", ")} m`);
    if (data.reactions && !motion.byHand) {
        const r = data.reactions.subarray(6 * (motion.sample * data.bodies.length + body));
        lines.push(`joint force ${digits(Math.hypot(r[0], r[1], r[2]))} N`);
    }
    return lines.join("\n");
}

export function describeSite(site, data, motion) {
    const on = site.body < 0 ? "the world" : data.bodies[site.body].name || `body ${site.body}`;
    return `site ${site.name}\non ${on}\nat ${motion.point(site.body, site.frame).map(digits).join(", ")} m`;
}
