// Bodies pulled by the pointer: a spring from where it took hold to a point in the plane of the picture.
// SPDX-License-Identifier: BSD-3-Clause
import { BufferAttribute, BufferGeometry, Line, LineBasicMaterial, Plane, Raycaster, Vector2, Vector3 } from "three";
import { $ } from "./dom.js";

export class Hand {
    constructor(viewer, simulation) {
        Object.assign(this, { viewer, simulation, caster: new Raycaster(), plane: new Plane(), target: new Vector3() });
        this.line = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0xf2b705, depthTest: false }));
        this.line.geometry.setAttribute("position", new BufferAttribute(new Float32Array(6), 3));
        this.line.frustumCulled = this.line.visible = false;
        viewer.stage.scene.add(this.line);
        viewer.extras.hand = { group: this.line, move: () => this.#draw(), paint: () => {} };
        simulation.lost = () => this.release();
        this.ended = new AbortController();
        const { signal } = this.ended, view = $("view");
        view.addEventListener("pointerdown", (event) => this.#down(event), { signal, capture: true });
        view.addEventListener("pointermove", (event) => this.#move(event), { signal });
        for (const name of ["pointerup", "pointercancel"]) view.addEventListener(name, (event) => this.#up(event), { signal });
    }

    // A spring that swings with the weight of all about once a second, damped.
    #spring() {
        const { info } = this.simulation.given, mass = info.mass > 0 ? info.mass : 1, rate = 2 * Math.PI;
        return { stiffness: 2 * mass * rate * rate, damping: 1.4 * mass * rate };
    }

    #down(event) {
        if (event.button !== 0 || event.shiftKey) return;
        const { body, point } = this.viewer.hitAt(event.offsetX, event.offsetY);
        if (body < 0) return;
        event.stopImmediatePropagation();
        this.viewer.pick(body);
        this.take(body, point);
        $("view").setPointerCapture(event.pointerId);
        if (!this.simulation.playing) this.simulation.play(true);
    }

    // Of a point of the world on a body.
    take(body, point) {
        const { motion, stage } = this.viewer, m = motion.place(body), { map } = motion, at = point.toArray();
        const off = at.map((x, l) => x - map[m + 9 + l]);
        const own = [0, 1, 2].map((c) => off.reduce((sum, x, l) => sum + x * map[m + 3 * c + l], 0));
        this.plane.setFromNormalAndCoplanarPoint(stage.camera.getWorldDirection(new Vector3()), point);
        this.simulation.grab({ body, point: own, at, ...this.#spring() });
        this.held = { body, own };
        this.target.copy(point);
        this.line.visible = true;
    }

    drag(target) {
        this.target.copy(target);
        this.simulation.drag(target.toArray());
    }

    #move(event) {
        if (!this.held) return;
        const { clientWidth: w, clientHeight: h } = $("stage");
        this.caster.setFromCamera(new Vector2((2 * event.offsetX) / w - 1, 1 - (2 * event.offsetY) / h), this.viewer.stage.camera);
        const hit = this.caster.ray.intersectPlane(this.plane, new Vector3());
        if (hit) this.drag(hit);
    }

    #up(event) {
        if (!this.held) return;
        if ($("view").hasPointerCapture(event.pointerId)) $("view").releasePointerCapture(event.pointerId);
        this.release();
    }

    release() {
        this.held = null;
        this.line.visible = false;
        this.simulation.release();
    }

    #draw() {
        if (!this.held) return;
        const { array } = this.line.geometry.attributes.position;
        array.set(this.viewer.motion.point(this.held.body, this.held.own), 0);
        array.set(this.target.toArray(), 3);
        this.line.geometry.attributes.position.needsUpdate = true;
    }

    end() {
        this.ended.abort();
    }
}
