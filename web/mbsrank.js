// libmbsrank in JavaScript: models from files, dynamics, runs.
// SPDX-License-Identifier: BSD-3-Clause
import { Wasi } from "./wasi.js";

// What the library says went wrong. `status` is a name such as "MBSR_UNDETERMINED", "" where a text cannot be read or
// an argument does not fit; `body` and `force` are ids, -2: none.
export class MbsrankError extends Error {
    constructor(text, status = "", body = -2, force = -2) {
        super(text);
        Object.assign(this, { name: "MbsrankError", status, body, force });
    }
}

const encoder = new TextEncoder(), decoder = new TextDecoder();
const INFO = 0, PARAMETERS = 1, REPORT = 2, REPORT_TEXT = 3, PAGE = 4;

// A path without "." and "..".
function plain(path) {
    const parts = [];
    for (const part of path.split("/")) {
        if (part === "..") parts.pop();
        else if (part !== "." && part !== "") parts.push(part);
    }
    return parts.join("/");
}

const bytesOf = (content) => (typeof content === "string" ? encoder.encode(content) : new Uint8Array(content));

// The files of a model by their paths: that of the model, and others by a function or a table.
function finder(name, text, files) {
    const known = new Map([[plain(name), bytesOf(text)]]);
    const other = typeof files === "function" ? files : (path) => (files instanceof Map ? files.get(path) : files?.[path]);
    return (path) => {
        const key = plain(path);
        if (!known.has(key)) {
            const content = other(key);
            known.set(key, content === undefined || content === null ? undefined : bytesOf(content));
        }
        return known.get(key);
    };
}

// The options of `read` as the program has them.
function optionsOf(name, options) {
    const list = [name], pairs = (flag, table) => {
        for (const [key, value] of Object.entries(table ?? {})) list.push(flag, `${key}=${value}`);
    };
    const known = ["name", "files", "floating", "strict", "limits", "friction", "contacts", "start", "packages",
                   "arguments", "set"];
    for (const key of Object.keys(options))
        if (!known.includes(key)) throw new MbsrankError(`read: there is no option '${key}'; there are ${known.join(", ")}`);
    if (options.floating) list.push("--floating");
    if (options.strict) list.push("--strict");
    if (options.limits === false) list.push("--no-limits");
    if (options.friction === false) list.push("--no-friction");
    if (options.start !== undefined) list.push("--start", options.start);
    pairs("--package", options.packages);
    pairs("--arg", options.arguments);
    pairs("--set", options.set);
    return list;
}

// One instance of the module, with the memory of all models that are read by it.
export class Library {
    #views = {};

    constructor(module) {
        this.wasi = new Wasi(() => undefined);
        const instance = new WebAssembly.Instance(module, { wasi_snapshot_preview1: this.wasi.imports() });
        this.c = instance.exports;
        this.wasi.memory = this.c.memory;
        this.c._initialize();
    }

    get version() {
        return this.text(this.c.mbsr_version());
    }

    // Bytes of memory that the module has taken.
    get bytes() {
        return this.c.memory.buffer.byteLength;
    }

    // ---- memory; views end where it grows, and are made anew ----

    get doubles() {
        if (this.#views.buffer !== this.c.memory.buffer) this.#renew();
        return this.#views.doubles;
    }

    get ints() {
        if (this.#views.buffer !== this.c.memory.buffer) this.#renew();
        return this.#views.ints;
    }

    #renew() {
        const buffer = this.c.memory.buffer;
        this.#views = { buffer, doubles: new Float64Array(buffer), ints: new Int32Array(buffer) };
    }

    take(bytes) {
        const at = this.c.malloc(bytes || 1);
        if (at === 0) throw new MbsrankError("no memory", "MBSR_ERR_NO_MEMORY");
        return at;
    }

    text(at) {
        const bytes = new Uint8Array(this.c.memory.buffer), end = bytes.indexOf(0, at);
        return decoder.decode(bytes.subarray(at, end));
    }

    // Texts one behind the other, each with a NUL; to be freed.
    put(texts) {
        const bytes = encoder.encode(texts.map((text) => `${text}\0`).join("")), at = this.take(bytes.length + 1);
        new Uint8Array(this.c.memory.buffer, at, bytes.length).set(bytes);
        return at;
    }

    // A text of the module's, which is freed.
    taken(at) {
        if (at === 0) throw this.failure();
        const text = this.text(at);
        this.c.free(at);
        this.wasi.take();
        return text;
    }

    // ---- failures ----

    // What an mbsr_error says.
    errorAt(at) {
        const [status, body, force] = this.ints.subarray(at >> 2, (at >> 2) + 3);
        return new MbsrankError(this.text(at + 12), this.text(this.c.mbsr_status_name(status)), body, force);
    }

    // The last failure: as the library has told it, or as the program complained.
    failure() {
        const said = this.wasi.take().replace(/^mbsrank: /, "").trimEnd(), at = this.c.web_error();
        return said ? new MbsrankError(said) : this.errorAt(at);
    }

    // ---- models ----

    // A model from the text of a file: URDF, xacro, MJCF or SDF.
    read(text, options = {}) {
        const name = options.name ?? "model.xml", list = optionsOf(name, options), find = this.wasi.find;
        this.wasi.find = finder(name, text, options.files);
        this.wasi.take();
        try {
            const at = this.c.web_open(this.put(list), list.length, options.contacts === false ? 0 : 1);
            if (at === 0) throw this.failure();
            return new Model(this, at, this.wasi.find);
        } finally {
            this.wasi.find = find;
        }
    }
}

// `source`: the module's bytes, a compiled module, a Response or a promise of one of them; without it the file
// mbsrank.wasm beside this one.
export async function load(source) {
    let given = await source;
    if (given === undefined) {
        const place = new URL("mbsrank.wasm", import.meta.url);
        if (place.protocol === "file:") given = await (await import("node:fs/promises")).readFile(place);
        else given = await fetch(place);
    }
    if (given instanceof WebAssembly.Module) return new Library(given);
    if (typeof Response !== "undefined" && given instanceof Response) given = await given.arrayBuffer();
    return new Library(await WebAssembly.compile(given));
}

// ---- what is closed at the end ----

class Owned {
    #at;

    constructor(library, at, end) {
        Object.defineProperties(this, { library: { value: library }, end: { value: end } }); // not printed
        this.#at = at;
    }

    get at() {
        if (this.#at === 0) throw new MbsrankError(`this ${this.constructor.name} is closed`);
        return this.#at;
    }

    get closed() {
        return this.#at === 0;
    }

    // Itself; closed ones, whose memory is another's, throw.
    open() {
        return this.at && this;
    }

    // Gives its memory back; later calls throw.
    close() {
        if (this.#at !== 0) this.end(this.#at);
        this.#at = 0;
    }

    // Throws what a status that is not 0 stands for.
    check(status) {
        if (status !== 0) throw this.library.failure();
    }
}
if (Symbol.dispose) Owned.prototype[Symbol.dispose] = Owned.prototype.close;

// `count` numbers into memory.
function fill(library, where, at, numbers, count, name) {
    if (numbers?.length !== count)
        throw new MbsrankError(`${where}: ${name} has ${numbers?.length ?? "no"} numbers, ${count} are expected`);
    const to = library.doubles, first = at >> 3;
    for (let k = 0; k < count; ++k) {
        if (typeof numbers[k] !== "number") throw new MbsrankError(`${where}: ${name}[${k}] is no number`);
        to[first + k] = numbers[k];
    }
}

// Names of options that are none.
function refuse(where, options, known) {
    for (const name of Object.keys(options))
        if (!known.includes(name)) throw new MbsrankError(`${where}: there is no option '${name}', but ${known.join(", ")}`);
}

function room(where, to, count) {
    if (to === undefined) return new Float64Array(count);
    if (!(to instanceof Float64Array) || to.length !== count)
        throw new MbsrankError(`${where}: the result is a Float64Array of ${count}`);
    return to;
}

// ---- models ----

export class Model extends Owned {
    #info;

    constructor(library, at, find) {
        super(library, at, (one) => {
            library.c.free(this.memory);
            library.c.web_close(one);
        });
        const { c } = library;
        this.model = c.web_model_of(at);
        this.data = c.web_data_of(at);
        this.find = find;
        this.nq = c.mbsr_model_nq(this.model);
        this.nu = c.mbsr_model_nu(this.model);
        this.bodies = c.mbsr_model_bodies(this.model);
        // q, u, two more of nu, 12 a body
        const memory = library.take(8 * (this.nq + 3 * this.nu + 12 * this.bodies + 16));
        Object.assign(this, { memory, atQ: memory, atU: memory + 8 * this.nq });
        this.atIn = this.atU + 8 * this.nu;
        this.atOut = this.atIn + 8 * this.nu;
    }

    // A text of the module's, which may look at files.
    #text(what, q, u) {
        const { library, at } = this, { wasi } = library, find = wasi.find;
        this.#state("report", q ?? this.start().q, u ?? new Float64Array(this.nu));
        wasi.find = this.find;
        try {
            return library.taken(library.c.web_text(at, what, this.atQ, this.atU));
        } finally {
            wasi.find = find;
        }
    }

    #state(where, q, u) {
        const { library } = this.open();
        fill(library, where, this.atQ, q, this.nq, "q");
        if (u !== undefined) fill(library, where, this.atU, u, this.nu, "u");
    }

    #result(at, to) {
        const first = at >> 3;
        to.set(this.library.doubles.subarray(first, first + to.length));
        return to;
    }

    // Name, bodies, joints, actuators, keys, findings and more.
    get info() {
        return (this.#info ??= JSON.parse(this.#text(INFO)));
    }

    // q, u and controls of a key, by its name; without one as drawn, or as the option `start` of `read` says.
    start(key) {
        const { at, library, nq, nu } = this, { c } = library;
        const number = key === undefined ? -1 : this.info.keys.indexOf(key);
        if (key !== undefined && number < 0) throw new MbsrankError(`start: there is no key '${key}'`);
        const numbers = (which, count) => {
            const from = c.web_key(at, number, which) >> 3;
            return from ? library.doubles.slice(from, from + count) : new Float64Array(count);
        };
        return { q: numbers(0, nq), u: numbers(1, nu), control: numbers(2, number < 0 ? 0 : this.info.actuators.length) };
    }

    // Inputs of the actuators: a view on the module's memory, of this call.
    get control() {
        const at = this.library.c.web_controls(this.at) >> 3;
        return this.library.doubles.subarray(at, at + this.info.actuators.length);
    }

    // ---- dynamics at a state ----

    // `last`: arguments behind the numbers of x.
    #dynamics(name, call, q, u, x, xName, last, out, t) {
        const { library, data, nu } = this, to = room(name, out, nu), at = this.at && this.atIn;
        this.#state(name, q, u ?? []);
        if (x !== undefined && x !== null) fill(library, name, at, x, nu, xName);
        const given = x === undefined || x === null ? 0 : at;
        const status = call(this.model, data, t, this.atQ, this.atU, given, ...last, this.atOut);
        if (status !== 0) throw library.errorAt(library.c.mbsr_data_error(data));
        return this.#result(this.atOut, to);
    }

    // u' of the forces of the model and tau (nu) on the joints.
    forwardDynamics(q, u, tau, out, t = 0) {
        return this.#dynamics("forwardDynamics", this.library.c.mbsr_forward_dynamics, q, u, tau, "tau", [], out, t);
    }

    // The forces on the joints with which u' is as given.
    inverseDynamics(q, u, udot, out, t = 0) {
        return this.#dynamics("inverseDynamics", this.library.c.mbsr_inverse_dynamics, q, u, udot ?? [], "udot", [0], out, t);
    }

    // nu x nu, symmetric.
    massMatrix(q, t = 0) {
        const { library, nu } = this, to = library.take(8 * nu * nu);
        try {
            this.#state("massMatrix", q);
            this.check(library.c.web_mass_matrix(this.at, t, this.atQ, to));
            return this.#result(to, new Float64Array(nu * nu));
        } finally {
            library.c.free(to);
        }
    }

    // J.
    energy(q, u, t = 0) {
        this.#state("energy", q, u ?? []);
        this.check(this.library.c.web_energy(this.at, t, this.atQ, this.atU, this.atOut));
        const [kinetic, potential] = this.#result(this.atOut, new Float64Array(2));
        return { kinetic, potential };
    }

    // 12 numbers a body: its axes by columns, then its origin (m).
    poses(q, out, t = 0) {
        const to = room("poses", out, 12 * this.bodies);
        this.#state("poses", q);
        this.check(this.library.c.web_poses(this.at, t, this.atQ, this.atOut));
        return this.#result(this.atOut, to);
    }

    // Of each body how many rates its joint has, and how many of them move mass.
    ranks(q, u = new Float64Array(this.nu), t = 0) {
        const { library, bodies } = this;
        this.#state("ranks", q, u);
        this.check(library.c.web_ranks(this.at, t, this.atQ, this.atU, this.atOut));
        const numbers = library.ints.subarray(this.atOut >> 2, (this.atOut >> 2) + 2 * bodies);
        return Array.from({ length: bodies }, (_, k) => ({ rates: numbers[2 * k], rank: numbers[2 * k + 1] }));
    }

    // Oscillations about the consistent state near q and u, slowest first: { frequency (Hz), damping, rate (1/s) } of each,
    // in motions exp(rate t) sin(2 pi frequency t). For models of 400 coordinates and momenta at most.
    modes(q = this.start().q, u = new Float64Array(this.nu), t = 0) {
        const { library } = this, { c } = library;
        this.#state("modes", q, u);
        const at = c.web_modes(this.at, t, this.atQ, this.atU, this.atOut);
        if (at === 0) throw library.failure();
        try {
            const count = library.ints[this.atOut >> 2], numbers = library.doubles.subarray(at >> 3, (at >> 3) + 2 * count);
            return Array.from({ length: count }, (_, k) => {
                const [rate, other] = numbers.subarray(2 * k, 2 * k + 2);
                return { frequency: other / (2 * Math.PI), damping: -rate / Math.hypot(rate, other), rate };
            });
        } finally {
            c.free(at);
        }
    }

    // What determines each direction without mass, and the index of the equations.
    report(q, u) {
        return JSON.parse(this.#text(REPORT, q, u));
    }

    reportText(q, u) {
        return this.#text(REPORT_TEXT, q, u);
    }

    // ---- parameters ----

    // name, value, unit, description of each
    get parameters() {
        return JSON.parse(this.#text(PARAMETERS));
    }

    // A model with other values of parameters, by their names; this one stays as it is.
    with(values) {
        const { at, library } = this, names = Object.keys(values), numbers = library.take(8 * names.length);
        const texts = library.put(names);
        try {
            fill(library, "with", numbers, Object.values(values), names.length, "the values");
            const made = library.c.web_with(at, names.length, texts, numbers);
            if (made === 0) throw library.failure();
            return new Model(library, made, this.find);
        } finally {
            library.c.free(texts);
            library.c.free(numbers);
        }
    }

    // ---- motions ----

    // A run by the driver, which chooses its steps: { q, u, t, rtol, atol, initialStep, maxStep, maxOrder, maxSteps }.
    simulate(options = {}) {
        refuse("simulate", options, ["q", "u", "t", "rtol", "atol", "initialStep", "maxStep", "maxOrder", "maxSteps"]);
        this.#begin("simulate", options);
        const { library, at } = this, numbers = this.atOut;
        const { rtol = 1e-6, atol = 1e-6, initialStep = 0, maxStep = 0, maxOrder = 5, maxSteps = 1e6 } = options;
        fill(library, "simulate", numbers, [rtol, atol, initialStep, maxStep, maxOrder, maxSteps], 6, "the options");
        const run = library.c.web_run(at, options.t ?? 0, this.atQ, this.atU, numbers);
        if (run === 0) throw library.failure();
        return new Run(this, run);
    }

    // Steps of fixed size: { q, u, t, h, order }; pull: { body, point, at, stiffness, damping } takes hold of a point
    // of a body (body axes) by a spring, whose other end, `at` in the world at first, moves by `drag`.
    stepper(options = {}) {
        refuse("stepper", options, ["q", "u", "t", "h", "order", "pull"]);
        const { h = 1e-3, order = 2, pull, ...state } = options, { library } = this;
        const model = pull ? this.#pulled(pull) : this;
        this.#begin("stepper", state);
        const at = library.c.web_stepper(model.at, h, order, state.t ?? 0, this.atQ, this.atU);
        if (at !== 0) return new Stepper(model, at, pull);
        const failure = library.failure();
        if (pull) model.close();
        throw failure;
    }

    #begin(where, { q, u }) {
        const start = q && u ? undefined : this.start();
        this.#state(where, q ?? start.q, u ?? (q ? new Float64Array(this.nu) : start.u));
    }

    #pulled({ body, point, at, stiffness, damping }) {
        const { library } = this.open(), to = this.atOut;
        fill(library, "stepper", to, point, 3, "pull.point");
        fill(library, "stepper", to + 24, at, 3, "pull.at");
        const made = library.c.web_pulled(this.at, body, to, to + 24, stiffness, damping);
        if (made === 0) throw library.failure();
        return new Model(library, made, this.find);
    }

    // States side by side: q (nq x count), u and tau (nu x count) one behind the other, and so is u'.
    batch(q, u, tau, t = 0) {
        const { library, nq, nu } = this.open(), { c } = library, count = Math.ceil(q?.length / nq || 1);
        const memory = library.take(8 * count * (nq + 3 * nu)), atU = memory + 8 * count * nq, step = 8 * count * nu;
        const batch = c.web_batch(this.at);
        try {
            if (batch === 0) throw library.failure();
            fill(library, "batch", memory, q, count * nq, "q");
            fill(library, "batch", atU, u, count * nu, "u");
            if (tau) fill(library, "batch", atU + step, tau, count * nu, "tau");
            const out = atU + 2 * step, given = tau ? atU + step : 0;
            if (c.mbsr_batch_forward_dynamics(this.model, batch, t, count, memory, atU, given, out, 0) !== 0)
                throw library.errorAt(c.mbsr_batch_error(batch));
            return this.#result(out, new Float64Array(count * nu));
        } finally {
            c.mbsr_batch_destroy(batch);
            c.free(memory);
        }
    }

    // The data of the page of `mbsrank view`, as JSON, near a state.
    page(q, u) {
        return this.#text(PAGE, q, u);
    }
}

// ---- motions ----

class Moving extends Owned {
    constructor(model, at, end) {
        super(model.library, at, (one) => {
            end(one);
            this.library.c.free(this.memory);
        });
        Object.assign(this, { nq: model.nq, nu: model.nu, bodies: model.bodies });
        this.memory = this.library.take(8 * (1 + this.nq + this.nu + 12 * this.bodies + 16));
    }

    numbers(at, count, out) {
        const first = at >> 3, { doubles } = this.library;
        if (!out) return doubles.slice(first, first + count);
        out.set(doubles.subarray(first, first + count));
        return out;
    }
}

// A run of the driver. t, q, u, udot and lambda (loop forces) are those reached.
export class Run extends Moving {
    constructor(model, at) {
        super(model, at, model.library.c.web_run_end);
        this.rows = model.library.c.mbsr_model_rows(model.model);
        this.#read();
    }

    #read() {
        const { library, memory, nq, nu, rows } = this;
        library.c.web_run_state(this.at, memory, memory + 8);
        const [q, u, udot, lambda] = library.ints.slice((memory + 8) >> 2, (memory + 24) >> 2);
        this.t = library.doubles[memory >> 3];
        this.q = this.numbers(q, nq);
        this.u = this.numbers(u, nu);
        this.udot = this.numbers(udot, nu);
        this.lambda = this.numbers(lambda, rows);
    }

    // On to a time; after a failure the state is the last good one.
    to(t) {
        const status = this.library.c.web_run_to(this.at, t);
        this.#read();
        this.check(status);
        return this;
    }

    // The state at each of these times: { t, q, u, udot, lambda }.
    *states(times) {
        for (const time of times) {
            const { t, q, u, udot, lambda } = this.to(time);
            yield { t, q, u, udot, lambda };
        }
    }

    get energy() {
        this.check(this.library.c.web_run_energy(this.at, this.memory));
        const [kinetic, potential] = this.numbers(this.memory, 2);
        return { kinetic, potential };
    }

    poses(out) {
        this.check(this.library.c.web_run_poses(this.at, this.memory));
        return this.numbers(this.memory, 12 * this.bodies, out);
    }

    // What it has cost.
    get stats() {
        this.library.c.web_run_stats(this.at, this.memory);
        const [steps, residuals, newtonIterations, newtonFailures, errorTestFailures, factorisations, solves, lastStep] =
            this.numbers(this.memory, 8);
        return { steps, residuals, newtonIterations, newtonFailures, errorTestFailures, factorisations, solves, lastStep };
    }
}

// Steps of fixed size.
export class Stepper extends Moving {
    constructor(model, at, pull) {
        super(model, at, (one) => {
            this.library.c.web_stepper_end(one);
            if (pull) model.close();
        });
        Object.assign(this, { pull, model });
        this.#read();
    }

    #read() {
        const { library, memory, nq, nu } = this, q = memory + 8, u = q + 8 * nq;
        library.c.web_stepper_motion(this.at, memory, q, u);
        this.t = library.doubles[memory >> 3];
        this.q = this.numbers(q, nq, this.q);
        this.u = this.numbers(u, nu, this.u);
    }

    // `count` steps; where one is refused the state is that before it.
    step(count = 1) {
        if (!Number.isInteger(count) || count < 0) throw new MbsrankError(`step: the count is ${count}`);
        const status = this.library.c.web_stepper_step(this.at, count);
        this.#read();
        this.check(status);
        return this;
    }

    // The other end of the spring that pulls is here from now on.
    drag(target) {
        if (!this.pull) throw new MbsrankError("drag: nothing is pulled");
        const { at, stiffness } = this.pull, held = this.library.c.web_held(this.model.at) >> 3;
        fill(this.library, "drag", this.memory, target, 3, "the target");
        for (let l = 0; l < 3; ++l) this.library.doubles[held + 3 + l] = stiffness * (target[l] - at[l]);
    }

    get energy() {
        this.check(this.library.c.web_stepper_energy(this.at, this.memory));
        const [kinetic, potential] = this.numbers(this.memory, 2);
        return { kinetic, potential };
    }

    poses(out) {
        const at = this.memory + 8 * (1 + this.nq + this.nu);
        this.check(this.library.c.web_stepper_poses(this.at, at));
        return this.numbers(at, 12 * this.bodies, out);
    }
}
