// A model that moves by steps of fixed size as time passes, beside the page that draws it (worker.js).
// SPDX-License-Identifier: BSD-3-Clause
export const lengths = [1 / 480, 1 / 240, 1 / 120, 1 / 60]; // of steps, s: longer ones where they take too long
const usual = 1; // the length to begin with
const most = 0.05; // of real time that is caught up with, s
const patience = 30; // ms of steps at a time
const calm = 4; // half seconds in which steps take little of the time, before they are shorter again

export class Runner {
    // Owns the model.
    constructor(model) {
        Object.assign(this, { model, given: model, length: usual, longest: lengths.length - 1, behind: 0, calm: 0, sum: this.#none() });
    }

    #none() {
        return { done: 0, wanted: 0, taken: 0, whole: 0 };
    }

    get state() {
        if (!this.stepper) throw new Error(this.refusal);
        const { q, u, t } = this.stepper;
        return { q: q.slice(), u: u.slice(), t };
    }

    // Begins anew at a state, with a spring of the hand or without; where the library refuses, what was before goes on.
    begin({ q, u, t = 0 }, pull) {
        let stepper;
        try {
            stepper = this.model.stepper({ q, u, t, h: lengths[this.length], order: 2, pull });
        } catch (error) {
            this.refusal = error.message;
            throw error;
        }
        this.stepper?.close();
        this.stepper = stepper;
        this.pull = pull && { ...pull }; // with where it is dragged to
        this.behind = 0;
    }

    // The model with these values of parameters, from a state, or from home where that cannot be.
    exchange(values, state, home) {
        const before = this.model;
        this.model = this.given.with(values);
        this.stepper?.close();
        this.stepper = undefined;
        if (before !== this.given) before.close();
        try {
            this.begin(state);
        } catch {
            this.begin(home);
        }
    }

    // Takes hold of a point of a body; without a pull it is let go.
    grab(pull) {
        this.begin(this.state, pull);
    }

    drag(target) {
        if (!this.pull) return;
        this.pull.at = target;
        this.stepper.drag(target);
    }

    // Steps for what has passed (s), no more than fit into it.
    advance(passed, speed) {
        const start = performance.now(), h = lengths[this.length], from = this.state.t;
        this.behind = Math.min(most * speed, this.behind + passed * speed);
        try {
            for (; this.behind >= h && performance.now() - start < patience; this.behind -= h) this.stepper.step();
        } catch (error) {
            this.#shorten(error);
        }
        const add = { done: this.stepper.t - from, wanted: passed * speed, taken: performance.now() - start, whole: passed };
        for (const [name, x] of Object.entries(add)) this.sum[name] += x;
        return this.sum.whole < 0.5 ? undefined : this.#judge();
    }

    // Shorter steps from where one was refused, and no longer ones from now on; throws if these are the shortest.
    #shorten(error) {
        if (this.length === 0) throw error;
        this.longest = --this.length;
        this.begin(this.state, this.pull);
    }

    // Longer steps where real time is not kept, shorter ones again after a while with time to spare; how fast it is.
    #judge() {
        const { done, wanted, taken, whole } = this.sum, rate = { share: done / wanted, load: taken / (1000 * whole), h: lengths[this.length] };
        this.sum = this.#none();
        this.calm = rate.share > 0.95 && rate.load < 0.25 ? this.calm + 1 : 0;
        let length = this.length;
        if (rate.share < 0.9 && rate.load > 0.5 && length < this.longest) ++length;
        if (this.calm >= calm && length > usual) --length;
        if (length === this.length || this.pull) return rate;
        this.length = length;
        this.calm = 0;
        this.begin(this.state);
        return rate;
    }
}
