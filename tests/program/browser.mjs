// A page in headless Chromium, over the pipe of its debugging protocol: no package is needed.
// SPDX-License-Identifier: BSD-3-Clause
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const patience = 300000; // ms: a watchdog, not a measure

export class Browser {
    constructor(program, width = 1280, height = 760) {
        this.folder = mkdtempSync(join(tmpdir(), "mbsrank-"));
        this.process = spawn(program, [
            "--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader", "--disable-gpu-compositing", "--hide-scrollbars", "--disable-extensions", "--disable-dev-shm-usage",
            `--user-data-dir=${this.folder}`, `--window-size=${width},${height}`, "--remote-debugging-pipe",
        ], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
        this.messages = []; // errors that the page has told
        this.waiting = new Map();
        this.last = 0;
        let text = "";
        this.process.stdio[4].on("data", (bytes) => {
            const parts = (text += bytes).split("\0");
            text = parts.pop();
            for (const part of parts) this.#receive(JSON.parse(part));
        });
    }

    #receive({ id, method, params, result, error }) {
        if (id) {
            const { keep, fail } = this.waiting.get(id);
            this.waiting.delete(id);
            if (error) fail(new Error(error.message));
            else keep(result);
        } else if (method === "Runtime.exceptionThrown") {
            this.messages.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
        } else if (method === "Runtime.consoleAPICalled" && params.type === "error") {
            this.messages.push(params.args.map((a) => a.value ?? a.description).join(" "));
        } else if (method === "Log.entryAdded" && params.entry.level === "error") {
            this.messages.push(params.entry.text);
        }
    }

    send(method, params = {}) {
        const id = ++this.last, message = { id, method, params };
        if (this.session) message.sessionId = this.session;
        this.process.stdio[3].write(JSON.stringify(message) + "\0");
        return new Promise((keep, fail) => {
            this.waiting.set(id, { keep, fail });
            setTimeout(() => fail(new Error(`${method}: no answer`)), patience).unref();
        });
    }

    // Opens a file, and waits until the page is ready.
    async open(path, scheme = "light") {
        const { targetId } = await this.send("Target.createTarget", { url: "about:blank" });
        const { sessionId } = await this.send("Target.attachToTarget", { targetId, flatten: true });
        this.session = sessionId;
        for (const domain of ["Runtime", "Log", "Page"]) await this.send(`${domain}.enable`);
        await this.send("Emulation.setEmulatedMedia",
            { features: [{ name: "prefers-color-scheme", value: scheme }] });
        await this.send("Page.navigate", { url: pathToFileURL(path).href });
        const late = Date.now() + patience;
        while (!(await this.ask("!!window.mbsrank && window.mbsrank.script().frames > 0"))) {
            if (this.messages.length > 0) throw new Error(this.messages.join("\n"));
            if (Date.now() > late) throw new Error(`${path} does not become ready`);
            await new Promise((next) => setTimeout(next, 100));
        }
    }

    // The value of an expression in the page.
    async ask(expression) {
        const { result, exceptionDetails } = await this.send("Runtime.evaluate",
            { expression, returnByValue: true, awaitPromise: true });
        if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
        return result.value;
    }

    async picture(path) {
        const { data } = await this.send("Page.captureScreenshot", { format: "png" });
        writeFileSync(path, Buffer.from(data, "base64"));
    }

    async end() {
        this.session = undefined;
        const ended = new Promise((next) => this.process.on("exit", next));
        await this.send("Browser.close").catch(() => this.process.kill());
        await ended;
        rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
    }
}
