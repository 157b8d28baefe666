// Copies of one geometry, each fixed to a body: one draw call for all of them.
// SPDX-License-Identifier: BSD-3-Clause
import { Color, InstancedMesh, Matrix4 } from "three";

export class Batch {
    constructor(geometry, material) {
        this.geometry = geometry;
        this.material = material;
        this.items = []; // { body, local, colour, sets }
    }

    // local: Matrix4 in the body; colour: a name of the style sheet, or red, green and blue; sets: of shapes of which
    // it is one (drawing.js).
    add(body, local, colour, sets) {
        this.items.push({ body, local: local.clone(), colour, sets });
    }

    build(scene, motion) {
        const count = this.items.length;
        this.mesh = new InstancedMesh(this.geometry, this.material, count);
        this.mesh.frustumCulled = false;
        this.mesh.userData.batch = this;
        this.geometry.computeBoundingSphere();
        this.map = new Int32Array(count);
        this.local = new Float64Array(12 * count);
        this.items.forEach((item, k) => {
            const e = item.local.elements;
            for (let column = 0; column < 4; ++column)
                for (let row = 0; row < 3; ++row) this.local[12 * k + 3 * column + row] = e[4 * column + row];
        });
        const out = this.mesh.instanceMatrix.array;
        for (let k = 0; k < count; ++k) out[16 * k + 15] = 1;
        scene.add(this.mesh);
    }

    // Items for which `shown` is false are moved to nowhere.
    show(motion, shown) {
        this.items.forEach((item, k) => (this.map[k] = shown(item) ? motion.place(item.body) : motion.nowhere));
    }

    paint(colours, picked) {
        const colour = new Color();
        this.items.forEach((item, k) => {
            if (item.body >= 0 && item.body === picked) colour.copy(colours.picked);
            else if (typeof item.colour === "string") colour.copy(colours[item.colour]);
            else colour.setRGB(...item.colour, "srgb");
            this.mesh.setColorAt(k, colour);
        });
        if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
    }

    isShown(k, motion) {
        return this.map[k] !== motion.nowhere;
    }

    // (map of the body) times (map in the body), for all.
    move(motion) {
        const { map, local } = this, maps = motion.map, out = this.mesh.instanceMatrix.array;
        for (let k = 0, l = 0, o = 0; k < map.length; ++k, l += 12, o += 16) {
            const m = map[k];
            const a = maps[m], b = maps[m + 1], c = maps[m + 2], d = maps[m + 3], e = maps[m + 4],
                f = maps[m + 5], g = maps[m + 6], h = maps[m + 7], i = maps[m + 8];
            let x = local[l], y = local[l + 1], z = local[l + 2];
            out[o] = a * x + d * y + g * z;
            out[o + 1] = b * x + e * y + h * z;
            out[o + 2] = c * x + f * y + i * z;
            (x = local[l + 3]), (y = local[l + 4]), (z = local[l + 5]);
            out[o + 4] = a * x + d * y + g * z;
            out[o + 5] = b * x + e * y + h * z;
            out[o + 6] = c * x + f * y + i * z;
            (x = local[l + 6]), (y = local[l + 7]), (z = local[l + 8]);
            out[o + 8] = a * x + d * y + g * z;
            out[o + 9] = b * x + e * y + h * z;
            out[o + 10] = c * x + f * y + i * z;
            (x = local[l + 9]), (y = local[l + 10]), (z = local[l + 11]);
            out[o + 12] = a * x + d * y + g * z + maps[m + 9];
            out[o + 13] = b * x + e * y + h * z + maps[m + 10];
            out[o + 14] = c * x + f * y + i * z + maps[m + 11];
        }
        this.mesh.instanceMatrix.needsUpdate = true;
    }
}

// Copies that point from one place to another, set anew from frame to frame: their z axis along the way,
// x and y of the length given.
export class Pointers {
    constructor(geometry, material, most) {
        this.mesh = new InstancedMesh(geometry, material, Math.max(1, most));
        this.mesh.frustumCulled = false;
        this.mesh.count = 0;
        const out = this.mesh.instanceMatrix.array;
        for (let k = 0; k < most; ++k) out[16 * k + 15] = 1;
    }

    clear() {
        this.mesh.count = 0;
    }

    // From (x, y, z) along the unit vector (a, b, c): thick across, long along it.
    add(x, y, z, a, b, c, thick, long) {
        const out = this.mesh.instanceMatrix.array, o = 16 * this.mesh.count++;
        // two directions across (Duff et al., 2017)
        const sign = c < 0 ? -1 : 1, s = -1 / (sign + c), t = a * b * s;
        out[o] = thick * (1 + sign * a * a * s);
        out[o + 1] = thick * sign * t;
        out[o + 2] = -thick * sign * a;
        out[o + 4] = thick * t;
        out[o + 5] = thick * (sign + b * b * s);
        out[o + 6] = -thick * b;
        out[o + 8] = long * a;
        out[o + 9] = long * b;
        out[o + 10] = long * c;
        out[o + 12] = x;
        out[o + 13] = y;
        out[o + 14] = z;
    }

    end() {
        this.mesh.instanceMatrix.needsUpdate = true;
    }
}

export const matrixOf = (at, quaternion, scale) => new Matrix4().compose(at, quaternion, scale);
