// Elements of the page.
// SPDX-License-Identifier: BSD-3-Clause
export const $ = (id) => document.getElementById(id);

export function element(name, properties = {}, ...children) {
    const node = Object.assign(document.createElement(name), properties);
    node.append(...children);
    return node;
}

export const note = (text) => element("p", { className: "note", textContent: text });

// A file for the user.
export function download(blob, name) {
    const link = element("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
