// Sliders for joint coordinates.
// SPDX-License-Identifier: BSD-3-Clause
import { element, note } from "./dom.js";
import { Kinematics, quaternionOf, vectorOf } from "./kinematics.js";
import { Loops } from "./loops.js";

const most = 100; // lines
const widest = 8 * Math.PI; // a range beyond this is none

// What can be moved: { name, unit, low, high, get(q), set(q, x), held: the coordinates that are set }.
function slidersOf(data, whole) {
    const list = [];
    data.joints.forEach((j, number) => {
        const at = data.bodies[j.body].q + j.position, name = j.name || `joint ${number}`;
        const one = (part, unit, range, held, get, set) =>
            list.push({ name: part ? `${name}.${part}` : name, unit, low: range[0], high: range[1], held, get, set });
        const plain = (part, unit, range, k) => one(part, unit, range, [k], (q) => q[k], (q, x) => (q[k] = x));
        const turns = [-Math.PI, Math.PI], ways = [-whole, whole];
        const range = j.range && j.range[1] - j.range[0] <= widest ? j.range : j.kind === "slide" ? ways : turns;
        if (j.kind === "hinge") plain("", "rad", range, at);
        if (j.kind === "slide") plain("", "m", range, at);
        if (j.kind === "free")
            ["px", "py", "pz"].forEach((part, l) => {
                const here = data.coordinates[at + 4 + l];
                plain(part, "m", [here - whole, here + whole], at + 4 + l);
            });
        if (j.kind !== "free" && j.kind !== "ball") return;
        ["rx", "ry", "rz"].forEach((part, l) => {
            const vector = (q) => vectorOf(q.slice(at, at + 4));
            one(part, "rad", turns, [at, at + 1, at + 2, at + 3], (q) => vector(q)[l], (q, x) => {
                const v = vector(q);
                v[l] = x;
                quaternionOf(v).forEach((c, k) => (q[at + k] = c));
            });
        });
    });
    return list;
}

export class Joints {
    // moved(): the maps of the motion are by hand now.
    constructor(root, data, motion, whole, moved) {
        Object.assign(this, { data, motion, moved, kinematics: new Kinematics(data), sliders: slidersOf(data, whole) });
        this.loops = new Loops(data, this.kinematics, whole);
        this.q = motion.coordinates();
        if (this.sliders.length === 0) {
            root.append(note("Nothing moves."));
            return;
        }
        this.search = element("input", { type: "search", placeholder: `${this.sliders.length} coordinates` });
        this.search.addEventListener("input", () => this.#list());
        const back = element("button", { textContent: "back", title: "As at the start, or at the time shown" });
        back.addEventListener("click", () => this.reset());
        this.lines = element("div", { className: "sliders" });
        root.append(element("div", { className: "row" }, this.search, back), this.lines);
        this.#list();
    }

    #list() {
        const wanted = this.search.value.toLowerCase();
        const found = this.sliders.filter((s) => s.name.toLowerCase().includes(wanted));
        this.rows = found.slice(0, most).map((slider) => {
            const input = element("input", { type: "range", min: slider.low, max: slider.high, step: "any",
                                             ariaLabel: slider.name });
            const value = element("output"), name = element("span", { textContent: slider.name, title: slider.name });
            input.addEventListener("input", () => this.set(slider, Number(input.value)));
            return { slider, input, value, node: element("label", { className: "slider" }, name, input, value) };
        });
        this.lines.replaceChildren(...this.rows.map((r) => r.node));
        if (found.length > most) this.lines.append(note(`${found.length - most} more`));
        this.show();
    }

    // Where loops do not close any more, nothing moves.
    set(slider, x) {
        const q = Float64Array.from(this.q);
        slider.set(q, x);
        if (slider.held.length === 1) this.kinematics.follow(q, slider.held[0]);
        this.q = this.loops.some ? (this.loops.close(q, slider.held) ?? this.q) : q;
        this.kinematics.place(this.q, this.motion.map);
        this.motion.byHand = true;
        this.show();
        this.moved();
    }

    // By name, for scripts.
    setByName(name, x) {
        this.set(this.sliders.find((s) => s.name === name), x);
    }

    // From what is by hand to the time shown.
    reset() {
        this.motion.go(this.motion.time);
        this.pull();
        this.moved();
    }

    // Takes the coordinates of the motion.
    pull() {
        if (this.motion.byHand || this.sliders.length === 0) return;
        this.q = this.motion.coordinates();
        this.show();
    }

    show() {
        for (const { slider, input, value } of this.rows ?? []) {
            const x = slider.get(this.q);
            input.value = x;
            value.textContent = `${x.toFixed(3)} ${slider.unit}`;
        }
    }
}
