// What the colours mean, and what is shown.
// SPDX-License-Identifier: BSD-3-Clause
import { element } from "./dom.js";
import { COLLISION, LINKS, VISUAL } from "./drawing.js";

function swatch(name) {
    const node = element("span", { className: "swatch" });
    node.style.background = `var(--${name})`;
    return node;
}

const extras = { axes: ["joint", "axes of joints"], frames: ["x", "frames of bodies"], sites: ["z", "sites"],
                 forces: ["force", "forces of joints"], moments: ["moment", "moments of joints"],
                 loops: ["loop", "forces of closures"], turns: ["turn", "moments of closures"],
                 contacts: ["contact", "forces of contact"] };

// What `viewer` does not have cannot be shown, and data.without says why.
export function addLegend(root, viewer) {
    const { data } = viewer, rows = [["body", "bodies"], ["massless", "bodies without mass"]];
    if (!data.bodies.some((b) => b.massless)) rows.pop();
    for (const [colour, text] of rows) root.append(element("label", { className: "plain" }, swatch(colour), text));
    if (data.shapes.some((s) => s.contact !== s.visual)) root.append(shapesOf(viewer));
    if (viewer.drawing.drawn.size < data.bodies.length) root.append(linksOf(viewer));
    for (const [name, [colour, text]] of Object.entries(extras)) {
        if ((name === "sites" && data.sites.length === 0) || (/loops|turns/.test(name) && data.loops.length === 0) ||
            (name === "contacts" && data.contacts === 0)) continue;
        const there = viewer.extras[name];
        const box = element("input", { type: "checkbox", id: `show-${name}`, disabled: !there });
        const label = element("label", {}, box, swatch(colour), text);
        if (!there) {
            label.className = "off";
            label.title = data.without;
        }
        box.addEventListener("change", () => viewer.showExtra(name, box.checked));
        root.append(label);
    }
}

// Which shapes are shown, links being left as they are.
function shapesOf(viewer) {
    const select = element("select", { id: "sets" });
    for (const [sets, text] of [[VISUAL, "visual"], [COLLISION, "collision"], [VISUAL | COLLISION, "both"]])
        select.append(element("option", { value: sets, textContent: text }));
    select.addEventListener("change", () => viewer.showSets(Number(select.value), VISUAL | COLLISION));
    return element("label", { className: "plain" }, "shapes", select);
}

function linksOf(viewer) {
    const box = element("input", { type: "checkbox", id: "show-links", checked: (viewer.drawing.sets & LINKS) !== 0 });
    box.addEventListener("change", () => viewer.showSets(box.checked ? LINKS : 0, LINKS));
    return element("label", {}, box, "bodies without shapes");
}
