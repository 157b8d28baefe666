// Sliders for the parameters of a model, those of masses, springs and dampers unless others are looked for, and beside them what the driver takes for a second of its motion.
// SPDX-License-Identifier: BSD-3-Clause
import { element, note } from "./dom.js";

const most = 60; // lines
const first = /[.](mass|stiffness|damping)$/;

// The largest rate (1/s) at which the model swings about q, by iterations of the matrix of u' = A dq; NaN: none is found.
export function fastest(model, q) {
    const { nu, nq, info } = model, u = new Float64Array(nu), size = 1e-6;
    if (nu !== nq || nu === 0 || info.rows > 0) return NaN; // quaternions; loops
    const zero = model.forwardDynamics(q, u);
    let v = Float64Array.from({ length: nu }, (_, k) => Math.sin(1 + k)), square = 0;
    for (let k = 0; k < 60; ++k) {
        const length = Math.hypot(...v) || 1, there = q.map((x, l) => x + (size * v[l]) / length);
        const next = model.forwardDynamics(there, u).map((x, l) => (x - zero[l]) / size);
        square = -next.reduce((sum, x, l) => sum + (x * v[l]) / length, 0);
        v = next;
    }
    return Math.sqrt(square);
}

export class Parameters {
    constructor(root, model, simulation) {
        Object.assign(this, { root, model, simulation, values: new Map() });
        this.all = model.parameters;
        const list = this.all.filter((p) => p.value > 0);
        this.list = [...list.filter((p) => first.test(p.name)), ...list.filter((p) => !first.test(p.name))];
        this.cost = element("p", { className: "note", id: "cost" });
        this.search = element("input", { type: "search", placeholder: `${this.list.length} parameters` });
        this.search.addEventListener("input", () => this.#lines());
        this.lines = element("div", { className: "sliders" });
        root.replaceChildren(element("div", { className: "row" }, this.search), this.lines, this.cost);
        this.#lines();
        this.measure();
    }

    #lines() {
        const wanted = this.search.value.toLowerCase();
        const found = this.list.filter((p) => (wanted ? p.name.toLowerCase().includes(wanted) : first.test(p.name)));
        this.lines.replaceChildren(...found.slice(0, most).map((p) => this.#line(p)));
        if (found.length > most) this.lines.append(note(`${found.length - most} more`));
    }

    #line({ name, value, unit, description }) {
        const now = this.values.get(name) ?? value, text = element("output");
        const input = element("input", { type: "range", min: 0, max: 2 * value, step: "any", ariaLabel: name });
        const tell = (x) => (text.textContent = `${Number(x.toPrecision(4))} ${unit}`);
        input.value = now;
        tell(now);
        input.addEventListener("input", () => {
            const x = Number(input.value) < 0.01 * value ? 0 : Number(input.value);
            tell(x);
            this.set(name, x);
        });
        const short = name.replace(/^(bodies|forces|closures)[.]/, "");
        return element("label", { className: "slider" }, element("span", { textContent: short, title: `${name}: ${description}` }),
                       input, text);
    }

    // A model with this value takes the place of the one that runs; false: it is refused, and says why.
    set(name, value) {
        this.values.set(name, value);
        if (name.endsWith(".mass")) this.#scaleTensor(name.slice(0, -4), value / this.#given(name));
        try {
            this.simulation.exchange(this.model.with(Object.fromEntries(this.values)));
        } catch (error) {
            this.simulation.fail(error.message);
            return false;
        }
        clearTimeout(this.waiting);
        this.waiting = setTimeout(() => this.measure(), 150);
        return true;
    }

    #given(name) {
        return this.all.find((p) => p.name === name).value;
    }

    // The moments of inertia of a body go with its mass.
    #scaleTensor(body, factor) {
        for (const p of this.all) if (p.name.startsWith(`${body}I`)) this.values.set(p.name, factor * p.value);
    }

    reset() {
        if (this.values.size === 0) return;
        this.values.clear();
        this.simulation.exchange(this.model.with({}));
        this.#lines();
        this.measure();
    }

    // From the state shown.
    measure() {
        const { model, q } = this.simulation, parts = [];
        try {
            const run = model.simulate({ q });
            try {
                run.to(1);
            } finally {
                this.steps = run.stats.steps;
                parts.push(`1 s of motion from here: ${this.steps} steps of the driver`);
                run.close();
            }
        } catch (error) {
            this.steps = undefined;
            parts.push(`the driver: ${error.message}`);
        }
        try {
            const rate = fastest(model, q) / (2 * Math.PI);
            if (rate > 0) parts.push(`fastest oscillation ${Number(rate.toPrecision(3))} Hz`);
        } catch {
            parts.push("directions without mass: see the report");
        }
        this.cost.textContent = parts.join("; ");
    }
}
