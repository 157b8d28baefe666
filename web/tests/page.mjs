// The page that runs models, in headless Chromium: runs, is pulled by the mouse, has masses set to zero, opens others.
// SPDX-License-Identifier: BSD-3-Clause
// Usage: node page.mjs PAGE PROJECT CHROMIUM [FOLDER]    FOLDER: pictures are kept there
import assert from "node:assert/strict";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [page, project, chromium, folder] = process.argv.slice(2);
const { Browser } = await import(pathToFileURL(join(project, "tests", "program", "browser.mjs")));
const browser = new Browser(chromium);

async function until(expression) {
    for (let k = 0; k < 600; ++k) {
        if (await browser.ask(expression)) return;
        await new Promise((next) => setTimeout(next, 100));
    }
    throw new Error(`it does not become true: ${expression}`);
}

const live = "window.mbsrank.live", keep = async (name) => folder && browser.picture(join(folder, `${name}.png`));
const mouse = (type, [x, y], buttons) =>
    browser.send("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons, clickCount: 1 });

// A place of the window where a body is drawn that can be pulled.
const place = () => browser.ask(`(() => {
    const { left, top, width, height } = document.getElementById("view").getBoundingClientRect(), { viewer } = ${live}.hand;
    for (let y = 20; y < height; y += 6)
        for (let x = 230; x < width; x += 6)
            if (viewer.hitAt(x, y).body > 0 && viewer.hitAt(x + 4, y + 4).body > 0) return [x + left, y + top];
    return null;
})()`);

async function openExample(name) {
    await browser.ask(`${live} && (window.mbsrank.old = true), (() => {
        const choice = document.getElementById("example");
        choice.value = ${JSON.stringify(name)};
        choice.dispatchEvent(new Event("change"));
    })()`);
    await until(`!!${live} && !window.mbsrank.old`);
}

try {
    await browser.open(page);
    await until(`!!window.mbsrank && !!${live}`);

    // it falls, and time goes on
    await browser.ask(`document.getElementById("play").click()`);
    await until(`${live}.simulation.stepper.t > 0.1`);
    assert.ok(await browser.ask(`window.mbsrank.pixels() > 5000`));

    // pulled upwards it rises above where it was
    await openExample("quarter_car.xml");
    const before = await browser.ask(`window.mbsrank.pose(2)[11]`), at = await place();
    await mouse("mousePressed", at, 1);
    await until(`${live}.hand.held !== null`);
    for (let k = 1; k <= 8; ++k) await mouse("mouseMoved", [at[0], at[1] - 8 * k], 1);
    await until(`window.mbsrank.pose(2)[11] > ${before} + 0.05`);
    await keep("pulled");
    await mouse("mouseReleased", [at[0], at[1] - 64], 0);
    assert.equal(await browser.ask(`${live}.hand.held`), null);

    // without the mass of the wheel one direction more is damped
    assert.equal(await browser.ask(`${live}.simulation.report().damped`), 1);
    await browser.ask(`${live}.parameters.set("bodies.wheel.mass", 0)`);
    assert.equal(await browser.ask(`${live}.simulation.report().damped`), 2);
    assert.equal(await browser.ask(`document.getElementById("counts").textContent`), "3 bodies, 2 without mass");
    await until(`/steps of the driver/.test(document.getElementById("cost").textContent)`);
    await keep("without_mass");

    // a joint by hand
    await browser.ask(`${live}.simulation.play(false), window.mbsrank.set("tyre", 0.03)`);
    assert.equal(await browser.ask(`${live}.simulation.stepper.q[0]`), 0.03);

    // others, the last of which is refused
    for (const name of ["suspension.xml", "gripper.xml", "wiper.sdf"]) {
        await openExample(name);
        await browser.ask(`${live}.simulation.play(true)`);
        await until(`${live}.simulation.stepper.t > 0.05`);
        assert.equal(await browser.ask(`document.getElementById("trouble").textContent`), "");
        await keep(name);
    }
    assert.deepEqual(browser.messages, []);
} finally {
    await browser.end();
}
