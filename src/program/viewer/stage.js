// The scene with its camera: frames are drawn when something has changed.
// SPDX-License-Identifier: BSD-3-Clause
import {
    AmbientLight,
    Box3,
    Color,
    DirectionalLight,
    GridHelper,
    HemisphereLight,
    Matrix4,
    PerspectiveCamera,
    Scene,
    Sphere,
    Vector3,
    WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const names = ["ground", "body", "fixed", "massless", "picked", "joint", "force", "moment", "loop", "turn", "contact", "x", "y", "z",
    "grid", "grid-axis"];

export function coloursOf(root) {
    const style = getComputedStyle(root), colours = {};
    for (const name of names) colours[name] = new Color(style.getPropertyValue(`--${name}`).trim());
    return colours;
}

// Whether frames are drawn by the processor, which takes three times as long for smooth edges.
export function isSoftware() {
    const gl = document.createElement("canvas").getContext("webgl2"), info = gl?.getExtension("WEBGL_debug_renderer_info");
    const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
    gl?.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export class Stage {
    constructor(canvas, smooth) {
        this.renderer = new WebGLRenderer({ canvas, antialias: smooth, context: canvas.getContext("webgl2", { alpha: false, antialias: smooth }) });
        this.sharpness = 1; // share of the screen's pixels along each axis
        this.scene = new Scene();
        this.camera = new PerspectiveCamera(40, 1, 0.01, 1000);
        this.camera.up.set(0, 0, 1);
        this.controls = new OrbitControls(this.camera, canvas);
        this.light = new DirectionalLight(0xffffff, 1.9);
        this.scene.add(new HemisphereLight(0xffffff, 0x8a8f99, 1.2), new AmbientLight(0xffffff, 0.3));
        this.camera.add(this.light);
        this.light.position.set(0.6, 1, 1.2);
        this.scene.add(this.camera);
    }

    // Looks at a box so that its corners just fit; the grid lies below it.
    frame(box, floor) {
        const sphere = box.getBoundingSphere(new Sphere()), r = sphere.radius || 1, corner = new Vector3();
        const back = new Vector3(0.62, -1, 0.42).normalize();
        const right = new Vector3().crossVectors(this.camera.up, back).normalize();
        const up = new Vector3().crossVectors(back, right);
        const high = Math.tan((Math.PI / 360) * this.camera.fov), wide = high * this.camera.aspect;
        let away = 0;
        for (let k = 0; k < 8; ++k) {
            corner.set(...["x", "y", "z"].map((c, l) => (k & (1 << l) ? box.max : box.min)[c])).sub(sphere.center);
            const out = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / high);
            away = Math.max(away, corner.dot(back) + 1.1 * out);
        }
        this.home = { target: sphere.center.clone(), position: sphere.center.clone().addScaledVector(back, away) };
        this.camera.near = 0.01 * r;
        this.camera.far = 60 * r;
        this.camera.updateProjectionMatrix();
        this.#lay(sphere, floor);
        this.goHome();
    }

    // The view that `frame` has found.
    goHome() {
        this.controls.target.copy(this.home.target);
        this.camera.position.copy(this.home.position);
        this.controls.update();
    }

    // Goes along with what has moved by x.
    follow(x) {
        const step = new Vector3(...x);
        this.controls.target.add(step);
        this.camera.position.add(step);
    }

    // Squares of 1, 2 or 5 times a power of ten.
    #lay(sphere, floor) {
        const wish = sphere.radius / 4, ten = 10 ** Math.floor(Math.log10(wish));
        this.square = [1, 2, 5, 10].map((f) => f * ten).find((s) => s >= wish);
        const count = 20, size = count * this.square;
        this.grid = new GridHelper(size, count);
        this.grid.rotateX(Math.PI / 2);
        this.grid.position.z = floor - 1e-3 * sphere.radius;
        this.scene.add(this.grid);
    }

    // Below what is looked at, square on square.
    #centreGrid() {
        for (const axis of ["x", "y"])
            this.grid.position[axis] = this.square * Math.round(this.controls.target[axis] / this.square);
    }

    paint(colours) {
        this.renderer.setClearColor(colours.ground);
        if (!this.grid) return;
        const { geometry } = this.grid, colour = geometry.attributes.color, lines = colour.count / 4;
        for (let k = 0; k < colour.count; ++k) {
            const middle = Math.floor(k / 4) === Math.floor(lines / 2);
            colours[middle ? "grid-axis" : "grid"].toArray(colour.array, 3 * k);
        }
        colour.needsUpdate = true;
    }

    fit(width, height, ratio = this.sharpness * Math.min(2, window.devicePixelRatio)) {
        this.renderer.setPixelRatio(ratio);
        this.renderer.setSize(width, height, false);
        this.camera.aspect = width / Math.max(1, height);
        this.camera.updateProjectionMatrix();
    }

    draw() {
        this.#centreGrid();
        this.renderer.render(this.scene, this.camera);
    }

    // How many pixels of a frame drawn now differ from its first corner.
    pixels() {
        const gl = this.renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
        const bytes = new Uint8Array(4 * w * h);
        this.draw();
        gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
        let other = 0;
        for (let k = 4; k < bytes.length; k += 4)
            other += bytes[k] !== bytes[0] || bytes[k + 1] !== bytes[1] || bytes[k + 2] !== bytes[2];
        return other;
    }
}

// Adds what is shown of bodies at the present state; only: that item of the batches.
export function growBox(box, batches, motion, only = -1) {
    const one = new Box3(), matrix = new Matrix4();
    for (const batch of batches) {
        batch.geometry.computeBoundingBox();
        for (let k = 0; k < batch.items.length; ++k) {
            if (batch.items[k].body < 0 || !batch.isShown(k, motion) || (only >= 0 && k !== only)) continue;
            matrix.fromArray(batch.mesh.instanceMatrix.array, 16 * k);
            box.union(one.copy(batch.geometry.boundingBox).applyMatrix4(matrix));
        }
    }
}
