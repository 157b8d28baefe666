// The tree of bodies: picked by name, shown or hidden.
// SPDX-License-Identifier: BSD-3-Clause
import { element, note } from "./dom.js";

const few = 60; // bodies: all are listed at first
const most = 200; // lines below one body

export class Tree {
    // pick(body), hide(bodies, whether)
    constructor(root, data, { pick, hide }) {
        Object.assign(this, { data, pick, hide, picked: -1, hidden: new Set(), rows: new Map() });
        this.carried = data.bodies.map(() => []);
        this.roots = [];
        data.bodies.forEach((b, k) => (b.parent < 0 ? this.roots : this.carried[b.parent]).push(k));
        this.open = new Set(data.bodies.length <= few ? data.bodies.keys() : this.roots);
        this.search = element("input", { type: "search", placeholder: `${data.bodies.length} bodies` });
        this.search.addEventListener("input", () => this.list());
        this.lines = element("div", { className: "tree" });
        const all = element("button", { textContent: "show all" });
        all.addEventListener("click", () => this.show(data.bodies.keys(), true));
        root.append(element("div", { className: "row" }, this.search, all), this.lines);
        this.list();
    }

    list() {
        const wanted = this.search.value.toLowerCase();
        this.rows.clear();
        this.lines.replaceChildren();
        if (!wanted) return this.#add(this.roots, 0);
        const found = [...this.data.bodies.keys()].filter((k) => this.#name(k).toLowerCase().includes(wanted));
        for (const k of found.slice(0, most)) this.lines.append(this.#row(k, 0));
        if (found.length > most) this.lines.append(note(`${found.length - most} more`));
    }

    #name(k) {
        return this.data.bodies[k].name || `body ${k}`;
    }

    #add(bodies, depth) {
        for (const k of bodies.slice(0, most)) {
            this.lines.append(this.#row(k, depth));
            if (this.open.has(k)) this.#add(this.carried[k], depth + 1);
        }
        if (bodies.length > most) this.lines.append(note(`${bodies.length - most} more`));
    }

    #row(k, depth) {
        const leaf = this.carried[k].length === 0 || this.search.value;
        const fold = element("button", { className: "fold", textContent: leaf ? "" : this.open.has(k) ? "▾" : "▸",
                                         disabled: leaf, ariaLabel: "What it carries" });
        const box = element("input", { type: "checkbox", checked: !this.hidden.has(k),
                                       title: "Shown; with shift also what it carries" });
        const name = element("button", { className: "name", textContent: this.#name(k) });
        const row = element("div", { className: "row" }, fold, box, name);
        row.style.paddingLeft = `${Math.min(depth, 20) * 12}px`;
        row.classList.toggle("massless", this.data.bodies[k].massless);
        row.classList.toggle("picked", k === this.picked);
        fold.addEventListener("click", () => {
            if (!this.open.delete(k)) this.open.add(k);
            this.list();
        });
        box.addEventListener("click", (event) => this.show(event.shiftKey ? this.#below(k) : [k], box.checked));
        name.addEventListener("click", () => this.pick(k === this.picked ? -1 : k));
        this.rows.set(k, row);
        return row;
    }

    // The body and all that it carries.
    #below(k) {
        const bodies = [k];
        for (let l = 0; l < bodies.length; ++l) bodies.push(...this.carried[bodies[l]]);
        return bodies;
    }

    show(bodies, on) {
        const list = [...bodies];
        for (const k of list) {
            if (on) this.hidden.delete(k);
            else this.hidden.add(k);
        }
        this.hide(list, !on);
        this.list();
    }

    // Marks the body, whose line comes into sight; -1: none.
    mark(body) {
        this.picked = body;
        for (let k = body < 0 ? -1 : this.data.bodies[body].parent; k >= 0; k = this.data.bodies[k].parent) this.open.add(k);
        this.list();
        this.rows.get(body)?.scrollIntoView({ block: "nearest" });
    }
}
