// The index report and the findings of the reader as tables.
// SPDX-License-Identifier: BSD-3-Clause
import { element, note } from "./dom.js";

const most = 500; // lines

function table(head, rows) {
    const node = element("table");
    const line = (cells, name) => element("tr", {}, ...cells.map((c) => element(name, { textContent: c })));
    node.append(line(head, "th"));
    for (const { cells, kind } of rows.slice(0, most)) {
        const row = line(cells, "td");
        if (kind) row.className = kind;
        node.append(row);
    }
    return node;
}

function ofTree(r) {
    const rows = r.directions.map((d) => ({
        kind: d.kind,
        cells: [d.kind, d.rates.map((t) => `${t.weight.toPrecision(3)} ${t.body}[${t.coordinate}]`).join(" ")],
    }));
    return [
        table(["directions", "how many"], [
            { cells: ["with mass", r.dynamic] },
            { cells: ["damped, without mass", r.damped] },
            { cells: ["elastic, without mass", r.elastic] },
            { cells: ["undetermined", r.undetermined], kind: r.undetermined > 0 ? "undetermined" : "" },
            { cells: ["index of the equations", r.index] },
        ]),
        ...(rows.length > 0 ? [note("Directions without mass"), table(["determined by", "rates"], rows)] : []),
    ];
}

function ofLoops(r) {
    const redundant = r.redundant.map((x) => ({ cells: [x.closure, x.row] }));
    return [
        table(["loops", ""], [
            { cells: ["rows of closures", r.rows] },
            { cells: ["independent ones", r.independent] },
            { cells: ["mobility", r.mobility] },
            { cells: ["directions without mass", r.massless] },
            { cells: ["of these held by no loop", r.unheld] },
            { cells: ["largest gap as drawn", r.gap.toPrecision(3)] },
            { cells: ["start", r.determined ? "determined" : "undetermined"],
              kind: r.determined ? "" : "undetermined" },
        ]),
        ...(redundant.length > 0 ? [note("Redundant rows"), table(["closure", "row"], redundant)] : []),
    ];
}

export function showReport(root, report) {
    if (!report) root.append(note("There is none for this state."));
    else root.append(...("directions" in report ? ofTree : ofLoops)(report));
}

export function showFindings(root, findings) {
    if (findings.length === 0) return false;
    root.append(table(["line", "element", "what is done"],
        findings.map((f) => ({ cells: [f.line, f.element, f.text] }))));
    if (findings.length > most) root.append(note(`${findings.length - most} more`));
    return true;
}
