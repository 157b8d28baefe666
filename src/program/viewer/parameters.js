// Sliders for the parameters of a model, those of masses, springs and dampers unless others are looked for, and beside them what the driver takes for a second of its motion.
// SPDX-License-Identifier: BSD-3-Clause
import { element, note } from "./dom.js";

const most = 60; // lines
const first = /[.](mass|stiffness|damping)$/;

const hertz = (x) => `${Number(x.toPrecision(3))}`;

// How a model swings about q, in words.
export function oscillations(model, q) {
    if (model.nq + model.nu > 400) return "";
    const list = model.modes(q).map(({ frequency }) => frequency), { length } = list;
    if (length === 0) return "no oscillation";
    if (length <= 3) return `${length > 1 ? "oscillations" : "oscillation"} ${list.map(hertz).join(", ")} Hz`;
    return `${length} oscillations, ${hertz(list[0])} to ${hertz(list.at(-1))} Hz`;
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
        root.replaceChildren(element("div", { className: "row" }, this.search), this.cost, this.lines);
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
            const values = Object.fromEntries(this.values);
            this.simulation.exchange(this.model.with(values), values);
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
        this.simulation.exchange(this.model.with({}), {});
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
            parts.push(oscillations(model, q));
        } catch (error) {
            parts.push(`oscillations: ${error.message}`);
        }
        this.cost.textContent = parts.filter(Boolean).join("; ");
    }
}
