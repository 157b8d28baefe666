// A model that moves in the page: steps of fixed size as time passes.
// SPDX-License-Identifier: BSD-3-Clause
import { $ } from "./dom.js";

const lengths = [1 / 480, 1 / 240, 1 / 120, 1 / 60]; // of steps, s: longer ones where they take too long
const most = 0.05; // of real time in a frame, s
const few = 50, enough = 57; // frames a second below which fewer pixels are drawn, and above which more may be
const blunt = 0.5; // least share of the screen's pixels along each axis

export class Simulation {
    constructor(model, viewer) {
        Object.assign(this, { model, viewer, given: model, playing: false, length: 1, longest: lengths.length - 1, behind: 0, drawn: 0, calm: 0, patience: 1 });
        this.changed = () => {};
        this.poses = new Float64Array(12 * model.bodies);
        const { q, u } = model.start();
        this.home = { q, u };
        viewer.joints.moved = () => this.#byHand();
        this.reset();
    }

    get q() {
        return this.stepper?.q ?? this.home.q;
    }

    // Begins anew at a state, with a spring of the hand or without; false: there is no such motion, and says why.
    begin({ q, u, t = 0 }, pull) {
        try {
            const stepper = this.model.stepper({ q, u, t, h: lengths[this.length], order: 2, pull });
            this.stepper?.close();
            this.stepper = stepper;
            this.fail("");
        } catch (error) {
            this.fail(error.message);
            return false;
        }
        this.show();
        return true;
    }

    fail(text) {
        $("trouble").hidden = !text;
        $("trouble").textContent = text;
        if (text) this.play(false);
    }

    get state() {
        return this.stepper ? { q: this.stepper.q.slice(), u: this.stepper.u.slice(), t: this.stepper.t } : { ...this.home, t: 0 };
    }

    reset() {
        this.behind = 0;
        this.begin(this.home);
        this.changed();
    }

    // Another model with the same coordinates; it is closed with this simulation.
    exchange(model) {
        const before = this.model, { state } = this;
        this.model = model;
        this.behind = 0;
        if (this.stepper) this.stepper.close();
        this.stepper = undefined;
        if (!this.begin(state)) this.begin(this.home);
        if (before !== this.given) before.close();
        this.changed();
    }

    report() {
        try {
            return this.model.report(this.q, new Float64Array(this.model.nu));
        } catch {
            return null;
        }
    }

    play(on) {
        this.playing = on && this.stepper !== undefined;
        $("play").textContent = this.playing ? "❚❚" : "▶";
    }

    #byHand() {
        this.begin({ q: this.viewer.joints.q, u: new Float64Array(this.model.nu), t: this.stepper?.t ?? 0 });
    }

    show() {
        const { viewer, stepper } = this, { motion, joints } = viewer;
        stepper.poses(this.poses);
        motion.map.set(this.poses);
        motion.byHand = true;
        joints.q = stepper.q.slice();
        if (++this.drawn % 6 === 0 || !this.playing) joints.show();
        $("time").textContent = `${stepper.t.toFixed(2)} s`;
        viewer.touch();
    }

    // Steps for the time that has passed, no more than fit into it.
    frame(now) {
        const whole = (now - (this.last ?? now)) / 1000, passed = Math.min(most, whole);
        this.last = now;
        if (!this.playing) return;
        const begin = performance.now(), from = this.stepper.t, speed = Number($("speed").value), h = lengths[this.length];
        this.behind = Math.min(most * speed, this.behind + passed * speed);
        try {
            for (; this.behind >= h && performance.now() - begin < 14; this.behind -= h) this.stepper.step();
        } catch (error) {
            if (!this.#shorten()) this.fail(error.message);
        }
        const taken = performance.now() - begin;
        this.#judge({ done: this.stepper.t - from, wanted: whole * speed, taken, whole, frames: 1 });
        this.show();
    }

    // Shorter steps from where one was refused, and no longer ones from now on; false: these are the shortest.
    #shorten() {
        if (this.length === 0) return false;
        this.longest = --this.length;
        this.behind = 0;
        return this.begin(this.state, this.pull);
    }

    // Fewer pixels where frames are few though steps are fast, more again after a while with enough of them: that while is
    // twice as long after each time that they were few.
    #sharpen(rate, passed, busy) {
        const { stage } = this.viewer, before = stage.sharpness;
        this.calm = rate > enough ? this.calm + passed : 0;
        if (rate < few && !busy && before > blunt) {
            stage.sharpness = Math.max(blunt, 0.7 * before);
            this.patience = Math.min(64, 2 * this.patience);
        } else if (this.calm > this.patience && before < 1) {
            stage.sharpness = Math.min(1, before / 0.7);
            this.calm = 0;
        }
        if (stage.sharpness !== before) this.viewer.fit();
    }

    // Longer steps where real time is not kept, fewer pixels where frames are few; says how fast it is.
    #judge(frame) {
        this.sum ??= { done: 0, wanted: 0, taken: 0, whole: 0, frames: 0 };
        for (const [name, x] of Object.entries(frame)) this.sum[name] += x;
        if (this.sum.whole < 0.5) return;
        const { done, wanted, taken, whole, frames } = this.sum, share = done / wanted, busy = taken > 500 * whole;
        this.#sharpen(frames / whole, whole, busy);
        $("rate").textContent = share < 0.95 ? `${(share * Number($("speed").value)).toFixed(2)} × real time` : "";
        this.rate = { share, load: taken / (1000 * whole), frames: frames / whole, h: lengths[this.length] };
        this.sum = undefined;
        if (share < 0.9 && busy && this.length < this.longest && !this.pulled) {
            ++this.length;
            this.begin(this.state);
        }
    }

    // Takes hold of a point of a body; release() lets it go.
    grab(pull) {
        this.pulled = this.begin(this.state, pull);
        this.pull = this.pulled ? { ...pull } : undefined; // with where it is dragged to
        return this.pulled;
    }

    drag(target) {
        if (!this.pulled) return;
        this.pull.at = target;
        this.stepper.drag(target);
    }

    release() {
        if (this.pulled) this.begin(this.state);
        this.pulled = false;
        this.pull = undefined;
    }

    end() {
        this.stepper?.close();
        if (this.model !== this.given) this.model.close();
        this.given.close();
    }
}
