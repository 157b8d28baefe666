// What is shown on demand: axes of joints, frames, and reactions as arrows.
// SPDX-License-Identifier: BSD-3-Clause
import { ConeGeometry, CylinderGeometry, Group, MeshBasicMaterial } from "three";
import { Pointers } from "./batch.js";

const rod = () => new CylinderGeometry(1, 1, 1, 8).rotateX(Math.PI / 2).translate(0, 0, 0.5);
const cone = () => new ConeGeometry(1, 1, 12).rotateX(Math.PI / 2).translate(0, 0, 0.5);

// Through everything else.
const onTop = () => new MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.9 });

// An axis for each one of a joint that turns or slides, as it stands at the coordinates 0.
export class Axes {
    constructor(data, motion, unitLength) {
        Object.assign(this, { motion, unitLength, axes: [] }); // axes: { body, parent, point, direction in the parent }
        data.bodies.forEach((b, k) => {
            for (const { direction: d } of b.axes) {
                const turned = [0, 1, 2].map((l) => b.A[3 + l] * d[0] + b.A[6 + l] * d[1] + b.A[9 + l] * d[2]);
                const length = Math.hypot(...turned);
                this.axes.push({ body: k, parent: b.parent, point: b.point, direction: turned.map((x) => x / length) });
            }
        });
        this.material = onTop();
        this.pointers = new Pointers(rod(), this.material, this.axes.length);
        this.group = new Group().add(this.pointers.mesh);
        this.group.visible = false;
    }

    move() {
        const { pointers, motion, unitLength } = this, long = 0.3 * unitLength, from = [0, 0, 0], v = [0, 0, 0];
        pointers.clear();
        for (const { body, parent, point, direction } of this.axes) {
            motion.point(body, point, from);
            motion.direction(parent, direction, v);
            pointers.add(from[0] - 0.5 * long * v[0], from[1] - 0.5 * long * v[1],
                from[2] - 0.5 * long * v[2], ...v, 0.012 * unitLength, long);
        }
        pointers.end();
    }

    paint(colours) {
        this.material.color.copy(colours.joint);
    }
}

// Frames { body, frame } as three rods along x, y and z: red, green and blue.
export class Frames {
    constructor(frames, motion, size) {
        Object.assign(this, { frames, motion, size });
        this.materials = ["x", "y", "z"].map(onTop);
        this.pointers = this.materials.map((material) => new Pointers(rod(), material, frames.length));
        this.group = new Group().add(...this.pointers.map((p) => p.mesh));
        this.group.visible = false;
    }

    move() {
        const { motion, size } = this, from = [0, 0, 0], v = [0, 0, 0];
        this.pointers.forEach((pointers, axis) => {
            pointers.clear();
            for (const { body, frame } of this.frames) {
                motion.point(body, frame, from);
                motion.direction(body, frame.slice(3 + 3 * axis, 6 + 3 * axis), v);
                pointers.add(...from, ...v, 0.03 * size, size);
            }
            pointers.end();
        });
    }

    paint(colours) {
        ["x", "y", "z"].forEach((axis, k) => this.materials[k].color.copy(colours[axis]));
    }
}

// Forces, or moments with two heads, of one kind (data.js); the largest one of the run is `longest`.
export class Arrows {
    constructor(arrows, motion, longest, moments, colour) {
        Object.assign(this, { arrows, motion, longest, moments, colour });
        this.material = onTop();
        this.shafts = new Pointers(rod(), this.material, arrows.count);
        this.heads = new Pointers(cone(), this.material, 2 * arrows.count);
        this.group = new Group().add(this.shafts.mesh, this.heads.mesh);
        this.group.visible = false;
        this.first = arrows.first + (moments ? 3 : 0);
        this.most = 0;
        const all = arrows.values;
        for (let k = this.first; k < all.length; k += arrows.stride)
            this.most = Math.max(this.most, Math.hypot(all[k], all[k + 1], all[k + 2]));
    }

    // As of the sample before the present time, between samples too; by hand there are none.
    move() {
        const { shafts, heads, motion, longest, first, most, arrows } = this, from = [0, 0, 0];
        const { count, stride, values: all } = arrows;
        shafts.clear();
        heads.clear();
        for (let k = 0, at = stride * count * motion.sample + first; k < count && !motion.byHand; ++k, at += stride) {
            const size = Math.hypot(all[at], all[at + 1], all[at + 2]);
            const long = (longest * size) / most, thick = 0.011 * longest;
            if (!(long > 0.01 * longest)) continue;
            const v = [all[at] / size, all[at + 1] / size, all[at + 2] / size];
            const head = Math.min(0.11 * longest, 0.6 * long);
            arrows.tail(k, from);
            shafts.add(...from, ...v, thick, long - 0.5 * head);
            for (let h = 0; h < (this.moments ? 2 : 1); ++h) {
                const back = long - head * (1 + 0.6 * h);
                heads.add(from[0] + back * v[0], from[1] + back * v[1], from[2] + back * v[2], ...v,
                    2.6 * thick, head);
            }
        }
        shafts.end();
        heads.end();
    }

    paint(colours) {
        this.material.color.copy(colours[this.colour]);
    }
}
