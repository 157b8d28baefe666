// A model that runs in the page: a worker makes the steps (worker.js), and the page shows what it tells.
// SPDX-License-Identifier: BSD-3-Clause
import { $ } from "./dom.js";

const late = 0.25; // time between frames beyond which it counts no more, s
const few = 50, enough = 57; // frames a second below which fewer pixels are drawn, and above which more may be
const blunt = 0.5; // least share of the screen's pixels along each axis

export class Simulation {
    // worker: with the model opened in it
    constructor(model, viewer, worker) {
        Object.assign(this, { model, viewer, worker, given: model, playing: false, asked: false, epoch: 0, drawn: 0, calm: 0, patience: 1 });
        this.changed = this.lost = () => {};
        this.home = this.state = { ...model.start(), t: 0 };
        this.frames = { count: 0, whole: 0 };
        worker.onmessage = ({ data }) => this.#receive(data);
        worker.onerror = ({ message }) => this.fail(message);
        viewer.joints.moved = () => this.#byHand();
        this.reset();
    }

    get q() {
        return this.state.q;
    }

    get t() {
        return this.state.t;
    }

    #call(name, ...args) {
        this.worker.postMessage({ name, args, epoch: this.epoch });
    }

    // Answers from before the state was set here tell nothing any more.
    #receive({ name, epoch, trouble, rate, q, u, t, poses, pulled }) {
        if (name === "advance") this.asked = false;
        if (epoch !== this.epoch) return;
        if (trouble !== undefined) this.fail(trouble);
        if (rate) this.#tell(rate);
        if (!poses) return;
        this.state = { q, u, t };
        if (this.pulled && !pulled) this.lost();
        this.#show(poses);
    }

    fail(text) {
        $("trouble").hidden = !text;
        $("trouble").textContent = text;
        if (text) this.play(false);
    }

    #begin(state) {
        ++this.epoch;
        this.state = state;
        this.#call("begin", state);
    }

    reset() {
        this.#begin(this.home);
        this.changed();
    }

    // Another model with the same coordinates, made by these values of parameters; it is closed with this simulation.
    exchange(model, values) {
        const before = this.model;
        this.model = model;
        ++this.epoch;
        this.#call("exchange", values, this.state, this.home);
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
        this.playing = on;
        this.last = undefined;
        $("play").textContent = this.playing ? "❚❚" : "▶";
    }

    #byHand() {
        this.#begin({ q: Float64Array.from(this.viewer.joints.q), u: new Float64Array(this.model.nu), t: this.t });
    }

    #show(poses) {
        const { viewer } = this, { motion, joints } = viewer;
        motion.map.set(poses);
        motion.byHand = true;
        joints.q = this.q.slice();
        if (++this.drawn % 6 === 0 || !this.playing) joints.show();
        $("time").textContent = `${this.t.toFixed(2)} s`;
        viewer.touch();
    }

    // The model goes on by the time that has passed since it was asked to before; nothing is asked until it has answered.
    frame(now) {
        if (!this.playing) return;
        const whole = (now - (this.last ?? now)) / 1000;
        this.last = now;
        this.waited = Math.min(late, (this.waited ?? 0) + whole);
        this.#judge(whole);
        if (this.asked) return;
        this.asked = true;
        this.#call("advance", this.waited, Number($("speed").value));
        this.waited = 0;
    }

    // Fewer pixels where frames are few, more again after a while with enough of them: that while is twice as long after
    // each time that they were few.
    #judge(passed) {
        const { stage } = this.viewer, before = stage.sharpness, { frames } = this;
        ++frames.count;
        frames.whole += passed;
        if (frames.whole < 0.5) return;
        const { count, whole } = frames;
        this.rate = { ...this.rate, frames: count / whole };
        this.frames = { count: 0, whole: 0 };
        this.calm = this.rate.frames > enough ? this.calm + whole : 0;
        if (this.rate.frames < few && before > blunt) {
            stage.sharpness = Math.max(blunt, 0.7 * before);
            this.patience = Math.min(64, 2 * this.patience);
        } else if (this.calm > this.patience && before < 1) {
            stage.sharpness = Math.min(1, before / 0.7);
            this.calm = 0;
        }
        if (stage.sharpness !== before) this.viewer.fit();
    }

    #tell(rate) {
        this.rate = { ...this.rate, ...rate };
        $("rate").textContent = rate.share < 0.95 ? `${(rate.share * Number($("speed").value)).toFixed(2)} × real time` : "";
    }

    // Takes hold of a point of a body; release() lets it go. Where that cannot be, lost() is called.
    grab(pull) {
        this.pulled = true;
        ++this.epoch;
        this.#call("grab", pull);
    }

    drag(target) {
        if (this.pulled) this.#call("drag", target);
    }

    release() {
        if (this.pulled) this.#call("grab");
        this.pulled = false;
    }

    end() {
        this.worker.terminate();
        if (this.model !== this.given) this.model.close();
        this.given.close();
    }
}
