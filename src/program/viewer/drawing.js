// What a model looks like: shapes of the file, and links between joints for bodies that have none.
// SPDX-License-Identifier: BSD-3-Clause
import {
    BoxGeometry,
    BufferAttribute,
    BufferGeometry,
    CylinderGeometry,
    Group,
    IcosahedronGeometry,
    MeshLambertMaterial,
    Quaternion,
    SphereGeometry,
    Vector3,
} from "three";
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { STLLoader } from "three/addons/loaders/STLLoader.js";
import { Batch, Pointers, matrixOf } from "./batch.js";
import { bytesOf } from "./data.js";

// What the readers give shapes without a colour.
const grey = (c) => c[0] === c[1] && c[1] === c[2] && (c[0] === 0.5 || c[0] === 0.7) && c[3] === 1;

const upright = (geometry) => geometry.rotateX(Math.PI / 2); // along z
const unit = {
    box: () => new BoxGeometry(2, 2, 2),
    sphere: () => new SphereGeometry(1, 24, 16),
    cylinder: () => upright(new CylinderGeometry(1, 1, 2, 32)),
    rod: (few) => upright(new CylinderGeometry(1, 1, 1, few ? 10 : 5)).translate(0, 0, 0.5),
    ball: (few) => (few ? new SphereGeometry(1, 16, 12) : new IcosahedronGeometry(1, 1)),
    plane: () => new BoxGeometry(2, 2, 1e-6),
};

function meshGeometry(name, base64) {
    const bytes = bytesOf(base64);
    if (/\.stl$/i.test(name)) return new STLLoader().parse(bytes.buffer);
    const position = [];
    if (/\.obj$/i.test(name)) {
        new OBJLoader().parse(new TextDecoder().decode(bytes)).traverse((node) => {
            if (!node.geometry) return;
            const flat = node.geometry.index ? node.geometry.toNonIndexed() : node.geometry;
            for (const x of flat.attributes.position.array) position.push(x);
        });
    }
    if (position.length === 0) return null;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(position), 3));
    geometry.computeVertexNormals();
    return geometry;
}

export class Drawing {
    constructor(data, motion, unitLength) {
        Object.assign(this, { data, motion, unitLength, batches: new Map(), trouble: [] });
        this.group = new Group();
        this.#addShapes();
        this.#addLinks();
        for (const batch of this.batches.values()) batch.build(this.group, motion);
        this.#addSlides();
    }

    // Transparent things are drawn behind the others, so they are apart.
    #batch(kind, opacity, geometry) {
        const key = `${kind} ${opacity}`;
        if (!this.batches.has(key)) {
            const material = new MeshLambertMaterial({ transparent: opacity < 1, opacity });
            if (opacity < 1) material.depthWrite = false;
            this.batches.set(key, new Batch(geometry ? geometry() : unit[kind](this.data.bodies.length < 2000), material));
        }
        return this.batches.get(key);
    }

    // Massless bodies shine through what they are inside of.
    #through() {
        const batch = this.#batch("ball", 0.6);
        batch.material.depthTest = false;
        return batch;
    }

    #addShapes() {
        const { data } = this, visual = new Set();
        this.drawn = new Set(); // bodies
        for (const s of data.shapes) if (s.visual) visual.add(s.body);
        for (const shape of data.shapes) {
            if (shape.body >= 0 && !shape.visual && visual.has(shape.body)) continue;
            if (this.#addShape(shape)) this.drawn.add(shape.body);
        }
    }

    #colour(body, given) {
        if (body >= 0 && this.data.bodies[body].massless) return "massless";
        return given && !grey(given) ? given.slice(0, 3) : body < 0 ? "fixed" : "body";
    }

    #addShape({ body, kind, at, turn, size, colour, mesh }) {
        const place = new Vector3(...at), q = new Quaternion(turn[1], turn[2], turn[3], turn[0]);
        const paint = this.#colour(body, colour), opacity = Math.min(1, colour[3]), [r, h] = size;
        const put = (name, scale, where = place, geometry = null) =>
            this.#batch(name, opacity, geometry).add(body, matrixOf(where, q, new Vector3(...scale)), paint);
        const along = (z) => new Vector3(0, 0, z).applyQuaternion(q).add(place);
        if (opacity === 0) return true;
        if (kind === "box") put("box", size);
        else if (kind === "sphere") put("sphere", [r, r, r]);
        else if (kind === "ellipsoid") put("sphere", size);
        else if (kind === "cylinder" || kind === "capsule") put("cylinder", [r, r, h]);
        else if (kind === "plane") return this.#addPlane(body, place, q, put, size);
        else return this.#addMesh(put, mesh, size);
        if (kind === "capsule") for (const end of [-h, h]) put("sphere", [r, r, r], along(end));
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

    #addMesh(put, name, scale) {
        const base64 = this.data.meshes[name], key = `mesh ${name}`;
        if (!base64) return false;
        const known = [...this.batches.keys()].some((k) => k.startsWith(key + " "));
        const geometry = known ? null : meshGeometry(name, base64);
        if (!known && !geometry) {
            this.trouble.push(`mesh '${name}' is neither STL nor OBJ`);
            return false;
        }
        put(key, scale, undefined, () => geometry);
        return true;
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
            this.#batch("ball", 1).add(k, place, this.#colour(k));
            if (b.massless) this.#through().add(k, place, "massless");
        });
    }

    #addRod(body, from, to, thick) {
        const way = to.clone().sub(from), length = way.length();
        if (length < 1e-6 * this.unitLength) return;
        const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), way.divideScalar(length));
        this.#batch("rod", 1).add(body, matrixOf(from, turn, new Vector3(thick, thick, length)), this.#colour(body));
    }

    // Between the two ends of joints that slide: how far they are out.
    #addSlides() {
        this.sliding = [];
        this.data.bodies.forEach((b, k) => {
            const slides = b.axes.some((a) => a.kind !== "hinge");
            if (slides && !b.ball) this.sliding.push(k);
        });
        this.slideMaterial = new MeshLambertMaterial();
        this.slides = new Pointers(unit.rod(true), this.slideMaterial, this.sliding.length);
        this.group.add(this.slides.mesh);
    }

    #moveSlides() {
        const { slides, motion, data } = this, a = [0, 0, 0], b = [0, 0, 0];
        slides.clear();
        for (const k of this.sliding) {
            motion.point(data.bodies[k].parent, data.bodies[k].anchor, a);
            motion.point(k, data.bodies[k].point, b);
            const x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2], length = Math.hypot(x, y, z);
            if (length < 1e-6 * this.unitLength) continue;
            slides.add(...a, x / length, y / length, z / length, 0.012 * this.unitLength, length);
        }
        slides.end();
    }

    move() {
        for (const batch of this.batches.values()) batch.move(this.motion);
        if (this.sliding.length > 0) this.#moveSlides();
    }

    paint(colours) {
        for (const batch of this.batches.values()) batch.paint(colours);
        this.slideMaterial.color.copy(colours.joint);
    }
}
