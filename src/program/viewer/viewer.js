// What is shown, and what can be done with it.
// SPDX-License-Identifier: BSD-3-Clause
import { Box3, Vector3 } from "three";
import { Motion, contactArrows, jointArrows, loopArrows } from "./data.js";
import { $ } from "./dom.js";
import { Drawing } from "./drawing.js";
import { pictureOf, videoOf } from "./export.js";
import { Arrows, Axes, Frames } from "./extras.js";
import { describe, describeSite, hitAt, siteAt } from "./hover.js";
import { Joints } from "./joints.js";
import { typicalLengths } from "./lengths.js";
import { Plots } from "./plots.js";
import { Stage, coloursOf, growBox } from "./stage.js";
import { Tree } from "./tree.js";

export class Viewer {
    constructor(data, meshes, smooth) {
        const motion = new Motion(data), { link, whole } = typicalLengths(data, meshes, motion);
        Object.assign(this, { data, motion, start: data.times[0], end: data.times.at(-1) });
        Object.assign(this, { playing: false, changed: true, moved: true, following: false, script: [] });
        this.stage = new Stage($("view"), smooth);
        this.drawing = new Drawing(data, meshes, motion, link, !smooth);
        this.batches = [...this.drawing.batches.values()];
        this.extras = this.#extras(link, whole);
        this.stage.scene.add(this.drawing.group, ...Object.values(this.extras).map((e) => e.group));
        this.plots = new Plots($("plots"), data, (t) => this.seek(t));
        this.tree = new Tree($("tree"), data, { pick: (body) => this.pick(body), hide: (list, on) => this.hide(list, on) });
        this.joints = new Joints($("joints"), data, motion, whole, () => this.touch());
        this.fit();
        this.#frameStart();
    }

    #extras(link, whole) {
        const { data, motion } = this, longest = 0.35 * whole, size = Math.max(0.2 * link, 0.03 * whole);
        const own = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1];
        const extras = { axes: new Axes(data, motion, link),
                         frames: new Frames(data.bodies.map((_, body) => ({ body, frame: own })), motion, size),
                         sites: new Frames(data.sites, motion, 0.5 * size) };
        if (!data.reactions) return extras;
        const joints = jointArrows(data, motion), loops = loopArrows(data, motion);
        extras.forces = new Arrows(joints, motion, longest, false, "force");
        extras.moments = new Arrows(joints, motion, longest, true, "moment");
        if (data.contactForces) extras.contacts = new Arrows(contactArrows(data, motion), motion, longest, false, "contact");
        if (loops.count === 0) return extras;
        extras.loops = new Arrows(loops, motion, longest, false, "loop");
        extras.turns = new Arrows(loops, motion, longest, true, "turn");
        return extras;
    }

    // The first view: all bodies as they are at the start, and where closures act.
    #frameStart() {
        const box = new Box3();
        this.drawing.move();
        growBox(box, this.batches, this.motion);
        for (let k = 0; this.data.loopForces && k < this.data.loops.length; ++k)
            box.expandByPoint(new Vector3().fromArray(this.data.loopForces, 9 * k));
        if (box.isEmpty()) box.set(box.min.set(-1, -1, -1), box.max.set(1, 1, 1));
        this.stage.frame(box, this.drawing.floor ?? box.min.z);
    }

    // ---- time ----

    seek(t) {
        this.motion.go(Math.min(this.end, Math.max(this.start, t)));
        $("slider").value = this.motion.time;
        $("time").textContent = `${this.motion.time.toFixed(3)} s`;
        if ($("joints").checkVisibility?.() ?? true) this.joints.pull();
        this.touch();
    }

    play(on) {
        this.playing = on && this.end > this.start;
        $("play").textContent = this.playing ? "❚❚" : "▶";
        if (this.playing && this.motion.time >= this.end) this.seek(this.start);
    }

    // Something has moved.
    touch() {
        this.moved = this.changed = true;
    }

    // ---- what is shown ----

    showExtra(name, on) {
        this.extras[name].group.visible = on;
        this.touch();
    }

    // Sets of drawing.js, of those in `among`.
    showSets(sets, among) {
        this.drawing.sets = (this.drawing.sets & ~among) | sets;
        this.drawing.show();
        this.touch();
    }

    hide(bodies, on) {
        for (const body of bodies) {
            if (on) this.drawing.hidden.add(body);
            else this.drawing.hidden.delete(body);
        }
        this.drawing.show();
        this.touch();
    }

    // -1: none
    pick(body) {
        this.drawing.picked = body;
        this.drawing.paint(coloursOf(document.documentElement));
        this.tree.mark(body);
        this.target = this.#focus();
        this.touch();
    }

    #picked() {
        return this.drawing.picked < 0 ? "" : describe(this.drawing.picked, this.data, this.motion);
    }

    // The camera goes along with the body picked, else with the centre of mass.
    follow(on) {
        this.following = on;
        this.target = this.#focus();
    }

    // What the camera follows.
    #focus() {
        const { motion } = this, body = this.drawing.picked;
        const at = body < 0 ? motion.centre() : motion.point(body, this.data.bodies[body].centre);
        return at.some(Number.isNaN) ? motion.point(0, this.data.bodies[0].point) : at;
    }

    #follow() {
        const at = this.#focus();
        this.stage.follow(at.map((x, l) => x - this.target[l]));
        this.target = at;
    }

    // As at first.
    reset() {
        this.play(false);
        this.seek(this.start);
        this.joints.pull();
        this.tree.show(this.drawing.hidden, true);
        this.pick(-1);
        this.stage.goHome();
    }

    paint() {
        const colours = coloursOf(document.documentElement);
        for (const one of [this.stage, this.drawing, ...Object.values(this.extras)]) one.paint(colours);
        this.plots.draw();
        this.changed = true;
    }

    setTheme(dark) {
        document.documentElement.classList.toggle("dark", dark);
        this.paint();
    }

    fit() {
        this.stage.fit($("stage").clientWidth, $("stage").clientHeight);
        this.plots.draw();
        this.changed = true;
    }

    // ---- the pointer, from the corner of the canvas in pixels ----

    #onCanvas(x, y) {
        const { clientWidth: w, clientHeight: h } = $("stage");
        return [(2 * x) / w - 1, 1 - (2 * y) / h, [40 / w, 40 / h]];
    }

    hitAt(x, y) {
        const [a, b] = this.#onCanvas(x, y);
        return hitAt(a, b, this.stage.camera, this.batches, this.motion);
    }

    bodyAt(x, y) {
        return this.hitAt(x, y).body;
    }

    hover(x, y) {
        const [a, b, reach] = this.#onCanvas(x, y), tip = $("hover"), { data, motion } = this;
        const sites = this.extras.sites.group.visible ? data.sites : [];
        const site = siteAt(a, b, reach, this.stage.camera, sites, motion), body = site ? -1 : this.bodyAt(x, y);
        tip.hidden = body < 0 && !site;
        if (tip.hidden) return;
        tip.textContent = site ? describeSite(site, data, motion) : describe(body, data, motion);
        tip.style.left = `${Math.min(x + 14, $("stage").clientWidth - tip.offsetWidth - 8)}px`;
        tip.style.top = `${Math.min(y + 14, $("stage").clientHeight - tip.offsetHeight - 8)}px`;
    }

    // ---- frames ----

    draw() {
        if (this.moved) {
            if (this.following) this.#follow();
            this.drawing.move();
            for (const one of Object.values(this.extras)) if (one.group.visible) one.move();
            this.plots.point(this.motion);
            $("picked").textContent = this.#picked();
            this.moved = false;
        }
        this.stage.controls.update();
        this.changed = false;
        this.stage.draw();
    }

    frame(now) {
        const before = performance.now(), passed = (now - (this.last ?? now)) / 1000;
        this.last = now;
        if (this.playing) {
            const t = this.motion.time + passed * Number($("speed").value), { start, end } = this;
            this.seek(t > end ? start + ((t - start) % (end - start)) : t);
        }
        this.stage.controls.update();
        if (this.changed && !this.filming) {
            this.draw();
            this.script.push(performance.now() - before);
            if (this.script.length > 200) this.script.shift();
        }
    }

    picture() {
        return pictureOf(this.stage);
    }

    // The run at the speed chosen, from its start to its end; a second call ends it.
    async film(progress) {
        if (this.filming) {
            this.filming = "ended";
            return null;
        }
        const { start, end, stage } = this, width = $("stage").clientWidth & ~1, height = $("stage").clientHeight & ~1;
        this.filming = "on";
        this.play(false);
        stage.fit(width, height, 2);
        try {
            return await videoOf(stage.renderer.domElement, (end - start) / Number($("speed").value), (part) => {
                this.seek(start + part * (end - start));
                this.draw();
            }, (part) => {
                progress(part);
                return this.filming === "on";
            });
        } finally {
            this.filming = undefined;
            this.fit();
        }
    }
}
