// Strips of chosen coordinates over time, with a cursor; a click goes there.
// SPDX-License-Identifier: BSD-3-Clause
import { element } from "./dom.js";

const most = 200; // names listed at a time
const first = 3; // columns chosen at first, of those that move

const short = (x) => Number(x.toPrecision(3)).toString();

function bounds(values) {
    let low = Infinity, high = -Infinity;
    for (const v of values) [low, high] = [Math.min(low, v), Math.max(high, v)];
    return [low, high];
}

function spread(values) {
    const [low, high] = bounds(values);
    return high - low;
}

class Strip {
    constructor(column, times, go) {
        Object.assign(this, { column, times });
        this.canvas = element("canvas");
        this.value = element("span");
        this.node = element("figure", { className: "strip" },
            element("figcaption", {}, element("span", { textContent: column.name }), this.value), this.canvas);
        const seek = (event) => {
            const box = this.canvas.getBoundingClientRect(), part = (event.clientX - box.left) / box.width;
            go(times[0] + Math.min(1, Math.max(0, part)) * (times.at(-1) - times[0]));
        };
        this.canvas.addEventListener("pointerdown", seek);
        this.canvas.addEventListener("pointermove", (event) => event.buttons && seek(event));
    }

    // The curve is drawn once into a picture of its own, over which the cursor moves.
    draw(style) {
        const ratio = window.devicePixelRatio || 1, { canvas, column, times } = this;
        const width = (canvas.width = Math.round(canvas.clientWidth * ratio) || 300);
        const height = (canvas.height = Math.round(canvas.clientHeight * ratio) || 96);
        this.picture = element("canvas", { width, height });
        const to = this.picture.getContext("2d");
        const [low, high] = bounds(column.values);
        const middle = 0.5 * (low + high), least = 1e-6 * Math.max(Math.abs(low), Math.abs(high)) || 1e-12;
        const half = Math.max(0.5 * (high - low), least) * 1.12;
        const span = times.at(-1) - times[0] || 1;
        const x = (t) => ((t - times[0]) / span) * width;
        const y = (v) => (0.5 - (0.5 * (v - middle)) / half) * height;
        to.fillStyle = style.getPropertyValue("--ground");
        to.fillRect(0, 0, width, height);
        to.strokeStyle = style.getPropertyValue("--line");
        to.lineWidth = ratio;
        to.beginPath();
        for (const v of low < 0 && high > 0 ? [low, 0, high] : [low, high]) {
            to.moveTo(0, y(v));
            to.lineTo(width, y(v));
        }
        to.stroke();
        to.strokeStyle = style.getPropertyValue("--accent");
        to.lineWidth = 1.6 * ratio;
        to.lineJoin = "round";
        to.beginPath();
        column.values.forEach((v, k) => to.lineTo(x(times[k]), y(v)));
        to.stroke();
        to.fillStyle = style.getPropertyValue("--faint");
        to.font = `${11 * ratio}px system-ui, sans-serif`;
        to.strokeStyle = style.getPropertyValue("--ground");
        to.lineWidth = 4 * ratio;
        for (const [v, down] of [[high, 12], [low, -4]]) {
            to.strokeText(short(v), 3 * ratio, y(v) + down * ratio);
            to.fillText(short(v), 3 * ratio, y(v) + down * ratio);
        }
        this.cursor = { at: x, colour: style.getPropertyValue("--text") };
    }

    point({ time, sample, part }) {
        if (!this.picture) return;
        const to = this.canvas.getContext("2d"), { values } = this.column;
        const next = values[Math.min(sample + 1, values.length - 1)];
        to.drawImage(this.picture, 0, 0);
        to.fillStyle = this.cursor.colour;
        to.fillRect(this.cursor.at(time) - 0.5, 0, window.devicePixelRatio || 1, this.canvas.height);
        this.value.textContent = (values[sample] + part * (next - values[sample])).toPrecision(5);
    }
}

export class Plots {
    constructor(root, data, go) {
        Object.assign(this, { data, go, strips: new Map() });
        if (data.columns.length === 0) return;
        this.choices = element("div", { id: "choices" });
        this.search = element("input", { type: "search", placeholder: `${data.columns.length} columns` });
        this.search.addEventListener("input", () => this.#list());
        this.shown = element("div");
        root.append(this.search, this.choices, this.shown);
        data.columns.filter((c) => spread(c.values) > 1e-6).slice(0, first).forEach((c) => this.#choose(c, true));
        this.#list();
    }

    #list() {
        const wanted = this.search.value.toLowerCase();
        const found = this.data.columns.filter((c) => c.name.toLowerCase().includes(wanted)).slice(0, most);
        this.choices.replaceChildren(...found.map((column) => {
            const box = element("input", { type: "checkbox", checked: this.strips.has(column) });
            box.addEventListener("change", () => {
                this.#choose(column, box.checked);
                this.draw();
            });
            return element("label", {}, box, column.name);
        }));
    }

    #choose(column, on) {
        if (on) {
            const strip = new Strip(column, this.data.times, this.go);
            this.strips.set(column, strip);
            this.shown.append(strip.node);
        } else {
            this.strips.get(column).node.remove();
            this.strips.delete(column);
        }
    }

    draw() {
        const style = getComputedStyle(document.documentElement);
        for (const strip of this.strips.values()) strip.draw(style);
        if (this.last) this.point(this.last);
    }

    point(motion) {
        this.last = motion;
        for (const strip of this.strips.values()) strip.point(motion);
    }
}
