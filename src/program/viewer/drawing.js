// What a model looks like: shapes of the file, and links between joints for bodies that have none.
// SPDX-License-Identifier: BSD-3-Clause
import {
    BoxGeometry,
    CapsuleGeometry,
    CylinderGeometry,
    DoubleSide,
    Group,
    IcosahedronGeometry,
    MeshLambertMaterial,
    Quaternion,
    SphereGeometry,
    Vector3,
} from "three";
import { Batch, Pointers, matrixOf } from "./batch.js";
import { mirrored } from "./meshes.js";

// Sets of things, of which some are shown; links stand for bodies without shapes.
export const VISUAL = 1, COLLISION = 2, LINKS = 4;

const upright = (geometry) => geometry.rotateX(Math.PI / 2); // along z
const many = 40; // bodies, from which on round shapes have fewer faces
// Faces around a round shape, and from its pole to its equator.
const faces = (bodies, coarse) => (bodies < many ? [32, 8] : coarse ? [8, 2] : [14, 4]);
const unit = {
    box: () => new BoxGeometry(2, 2, 2),
    sphere: ([around, up]) => new SphereGeometry(1, around, 2 * up),
    cylinder: ([around]) => upright(new CylinderGeometry(1, 1, 2, around)),
    capsule: ([around, up], length) => upright(new CapsuleGeometry(1, length, up, around)),
    rod: (_, bodies) => upright(new CylinderGeometry(1, 1, 1, bodies < 2000 ? 10 : 5)).translate(0, 0, 0.5),
    ball: (_, bodies) => (bodies < 2000 ? new SphereGeometry(1, 16, 12) : new IcosahedronGeometry(1, 1)),
    plane: () => new BoxGeometry(2, 2, 1e-6),
};

// The nearest of capsules whose lengths differ by 5 %, so that many are of one kind, and how it is stretched: radius and
// whole length are right, the round ends longer or shorter by 3 % at most.
function capsule(r, h) {
    const length = 2 * 1.05 ** Math.round(Math.log(h / r) / Math.log(1.05));
    return [`capsule ${length}`, [r, r, (h + r) / (1 + length / 2)]];
}

export class Drawing {
    // meshes: parts by name (meshes.js); coarse: round shapes of many bodies have few faces
    constructor(data, meshes, motion, unitLength, coarse) {
        Object.assign(this, { data, meshes, motion, unitLength, coarse, batches: new Map(), picked: -1 });
        this.hidden = new Set(); // bodies
        this.group = new Group();
        this.#addShapes();
        this.#addLinks();
        for (const batch of this.batches.values()) batch.build(this.group, motion);
        this.#addSlides();
        this.sets = VISUAL | (meshes.size > 0 ? 0 : LINKS); // frames of robots with meshes are in their way
        this.show();
    }

    // Transparent things are drawn behind the others, so they are apart.
    #batch(kind, opacity, geometry) {
        const key = `${kind} ${opacity}`;
        if (!this.batches.has(key)) {
            const material = new MeshLambertMaterial({ transparent: opacity < 1, opacity });
            if (opacity < 1) material.depthWrite = false;
            if (geometry) material.side = DoubleSide;
            this.batches.set(key, new Batch(geometry ?? this.#geometry(...kind.split(" ")), material));
        }
        return this.batches.get(key);
    }

    #geometry(kind, length) {
        const count = this.data.bodies.length;
        return unit[kind](faces(count, this.coarse), kind === "capsule" ? Number(length) : count);
    }

    // Massless bodies shine through what they are inside of.
    #through() {
        const batch = this.#batch("ball", 0.6);
        batch.material.depthTest = false;
        return batch;
    }

    // Of files without shapes for showing, those for contact are shown.
    #addShapes() {
        const { shapes } = this.data, some = shapes.some((s) => s.visual && s.body >= 0);
        this.drawn = new Set(); // bodies
        for (const shape of shapes) {
            const stands = shape.visual || (shape.contact && !some);
            const sets = (stands ? VISUAL : 0) | (shape.contact ? COLLISION : 0);
            if (sets && this.#addShape(shape, sets) && stands && shape.body >= 0) this.drawn.add(shape.body);
        }
    }

    #colour(body) {
        if (body >= 0 && this.data.bodies[body].massless) return "massless";
        return body < 0 ? "fixed" : "body";
    }

    #addShape({ body, kind, at, turn, size, colour, coloured, mesh }, sets) {
        const place = new Vector3(...at), q = new Quaternion(turn[1], turn[2], turn[3], turn[0]);
        const paint = coloured ? colour.slice(0, 3) : this.#colour(body), opacity = Math.min(1, colour[3]), [r, h] = size;
        const put = (name, scale) =>
            this.#batch(name, opacity).add(body, matrixOf(place, q, new Vector3(...scale)), paint, sets);
        if (opacity === 0) return true;
        if (kind === "box") put("box", size);
        else if (kind === "sphere") put("sphere", [r, r, r]);
        else if (kind === "ellipsoid") put("sphere", size);
        else if (kind === "cylinder") put("cylinder", [r, r, h]);
        else if (kind === "capsule") put(...capsule(r, h));
        else if (kind === "plane") return this.#addPlane(body, place, q, put, size);
        else {
            const scaled = matrixOf(place, q, new Vector3(...size));
            return this.#addMesh(mesh, body, scaled, coloured ? paint : null, opacity, sets);
        }
        return true;
    }

    // The grid stands for a level floor.
    #addPlane(body, place, q, put, size) {
        if (body < 0 && new Vector3(0, 0, 1).applyQuaternion(q).z > 0.999) {
            this.floor = place.z;
            return true;
        }
        put("plane", [size[0] || 4 * this.unitLength, size[1] || 4 * this.unitLength, 1]);
        return true;
    }

    // Its own colours stand where the file names none.
    #addMesh(name, body, place, colour, opacity, sets) {
        const parts = this.meshes.get(name) ?? [], turned = place.determinant() < 0;
        parts.forEach((part, k) => {
            if (turned) part.mirrored ??= mirrored(part.geometry);
            const shine = colour ? opacity : (part.opacity ?? opacity);
            this.#batch(`mesh ${turned} ${k} ${name}`, shine, turned ? part.mirrored : part.geometry)
                .add(body, place, colour ?? part.colour ?? this.#colour(body), sets);
        });
        return parts.length > 0;
    }

    // From a body's own joint to the joints that it carries; at an end to its centre of mass.
    #addLinks() {
        const { data } = this, carried = data.bodies.map(() => []);
        data.bodies.forEach((b) => b.parent >= 0 && carried[b.parent].push(b.anchor));
        data.bodies.forEach((b, k) => {
            if (this.drawn.has(k)) return;
            const from = new Vector3(...b.point), thick = 0.05 * this.unitLength;
            const ends = carried[k].length > 0 ? carried[k] : [b.centre];
            for (const end of ends) this.#addRod(k, from, new Vector3(...end), 0.5 * thick);
            const size = (b.massless ? 1.3 : 1) * thick;
            const place = matrixOf(from, new Quaternion(), new Vector3(size, size, size));
            this.#batch("ball", 1).add(k, place, this.#colour(k), LINKS);
            if (b.massless) this.#through().add(k, place, "massless", LINKS);
        });
    }

    #addRod(body, from, to, thick) {
        const way = to.clone().sub(from), length = way.length();
        if (length < 1e-6 * this.unitLength) return;
        const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), way.divideScalar(length));
        const place = matrixOf(from, turn, new Vector3(thick, thick, length));
        this.#batch("rod", 1).add(body, place, this.#colour(body), LINKS);
    }

    // Between the two ends of joints that slide: how far they are out.
    #addSlides() {
        this.sliding = [];
        this.data.bodies.forEach((b, k) => {
            const slides = b.axes.some((a) => a.kind !== "hinge");
            if (slides && !b.quaternion) this.sliding.push(k);
        });
        this.slideMaterial = new MeshLambertMaterial();
        this.slides = new Pointers(unit.rod(0), this.slideMaterial, this.sliding.length);
        this.group.add(this.slides.mesh);
    }

    #moveSlides() {
        const { slides, motion, data } = this, a = [0, 0, 0], b = [0, 0, 0];
        slides.clear();
        for (const k of this.sliding) {
            if (this.hidden.has(k)) continue;
            motion.point(data.bodies[k].parent, data.bodies[k].anchor, a);
            motion.point(k, data.bodies[k].point, b);
            const x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2], length = Math.hypot(x, y, z);
            if (length < 1e-6 * this.unitLength) continue;
            slides.add(...a, x / length, y / length, z / length, 0.012 * this.unitLength, length);
        }
        slides.end();
    }

    // After changes of `sets` and `hidden`.
    show() {
        const shown = ({ sets, body }) => (sets & this.sets) !== 0 && !this.hidden.has(body);
        for (const batch of this.batches.values()) batch.show(this.motion, shown);
    }

    move() {
        for (const batch of this.batches.values()) batch.move(this.motion);
        if (this.sliding.length > 0) this.#moveSlides();
    }

    // Of bodies that have gained or lost all mass.
    weigh() {
        for (const { items } of this.batches.values())
            for (const item of items)
                if (item.colour === "body" || item.colour === "massless") item.colour = this.#colour(item.body);
    }

    paint(colours) {
        for (const batch of this.batches.values()) batch.paint(colours, this.picked);
        this.slideMaterial.color.copy(colours.joint);
    }
}
