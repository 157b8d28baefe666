// Types of the package mbsrank. SI units; angles in rad. Numbers go in as arrays of exactly the length said and come
// out as new arrays, or in `out`. What fails throws an MbsrankError with the library's text.
// SPDX-License-Identifier: BSD-3-Clause

export type Numbers = ArrayLike<number>;
export type Content = string | Uint8Array | ArrayBuffer;

export class MbsrankError extends Error {
    /** Name of the library's status, "" where a text cannot be read or an argument does not fit. */
    readonly status: string;
    /** Ids of the body and the force element concerned, -2: none. */
    readonly body: number;
    readonly force: number;
}

/**
 * The library. `source`: the module's bytes, a compiled module, a Response, or a promise of one; without it the file
 * mbsrank.wasm beside the script.
 */
export function load(source?: BufferSource | WebAssembly.Module | Response
    | Promise<BufferSource | WebAssembly.Module | Response>): Promise<Library>;

export interface ReadOptions {
    /** Path of the file, for messages and as the folder of other files. */
    name?: string;
    /** Other files that the model names (meshes, includes), by their paths. */
    files?: Record<string, Content> | Map<string, Content> | ((path: string) => Content | undefined | null);
    /** URDF: the root link is free. */
    floating?: boolean;
    /** Findings make the reader refuse. */
    strict?: boolean;
    /** Limits of joints become stops, and dry friction acts (both true unless false). */
    limits?: boolean;
    friction?: boolean;
    /** Shapes for contact touch (true unless false). */
    contacts?: boolean;
    /** The key to start from. */
    start?: string;
    /** Folders of package://NAME/..., arguments of xacro, values of parameters. */
    packages?: Record<string, string>;
    arguments?: Record<string, string>;
    set?: Record<string, number>;
}

export class Library {
    readonly version: string;
    /** Bytes of memory that the module has taken. */
    readonly bytes: number;
    /** A model from the text of a file: URDF, xacro, MJCF or SDF. */
    read(text: Content, options?: ReadOptions): Model;
}

interface Closing {
    readonly closed: boolean;
    /** Gives the memory back; later calls throw. */
    close(): void;
    [Symbol.dispose](): void;
}

export interface Energy {
    /** J */
    kinetic: number;
    potential: number;
}

export interface Info {
    name: string;
    nq: number;
    nu: number;
    /** Rows of closures. */
    rows: number;
    /** kg, and the centre of mass in m, at the start. */
    mass: number;
    centre: [number, number, number];
    /** `parent` -1: the ground; `massless`: without moments of inertia too; `mass` null: the body is not rigid. */
    bodies: { name: string; parent: number; massless: boolean; mass: number | null }[];
    /** `q` and `u`: where its coordinates begin. */
    joints: { name: string; type: "fixed" | "hinge" | "slide" | "ball" | "free"; body: number; q: number; u: number;
              range: [number, number] | null }[];
    actuators: string[];
    keys: string[];
    /** Meshes that are not there. */
    missing: string[];
    /** What the file has and the model has not, and what is done instead. */
    findings: { file: string; line: number; element: string; text: string }[];
}

export interface Direction {
    kind: "undetermined" | "elastic" | "damped";
    rates: { body: string; coordinate: number; weight: number }[];
}

/** Directions by what determines them, and the differential index; with closures what their rows hold. */
export interface Report {
    index?: number;
    dynamic?: number;
    damped?: number;
    elastic?: number;
    undetermined?: number;
    directions?: Direction[];
    rows?: number;
    independent?: number;
    mobility?: number;
    massless?: number;
    unheld?: number;
    /** Largest gap as drawn. */
    gap?: number;
    determined?: boolean;
    redundant?: { closure: string; number: number; row: number }[];
}

export interface Parameter {
    name: string;
    value: number;
    unit: string;
    description: string;
}

export interface Start {
    /** nq numbers; as drawn without. */
    q?: Numbers;
    /** nu numbers; at rest without. */
    u?: Numbers;
    /** s */
    t?: number;
}

export interface RunOptions extends Start {
    rtol?: number;
    atol?: number;
    /** s; 0: chosen, none. */
    initialStep?: number;
    maxStep?: number;
    maxOrder?: number;
    maxSteps?: number;
}

export interface Pull {
    body: number;
    /** The point in the body, along its axes, and where it is in the world, m. */
    point: Numbers;
    at: Numbers;
    /** N/m and N s/m */
    stiffness: number;
    damping: number;
}

export interface StepperOptions extends Start {
    /** s */
    h?: number;
    order?: 1 | 2;
    /** Takes hold of a point of a body by a spring. */
    pull?: Pull;
}

/** A motion exp(rate t) sin(2 pi frequency t). */
export interface Mode {
    /** Hz */
    frequency: number;
    /** Share of the critical one; below zero where it grows. */
    damping: number;
    /** 1/s */
    rate: number;
}

export class Model implements Closing {
    readonly nq: number;
    readonly nu: number;
    readonly bodies: number;
    readonly info: Info;
    /** Name, value, unit and description of each. */
    readonly parameters: Parameter[];
    /** Inputs of the actuators, to be written; take it anew after other calls. */
    readonly control: Float64Array;
    readonly closed: boolean;
    /** q, u and controls of a key; without one as drawn, or as `start` of `read` says. */
    start(key?: string): { q: Float64Array; u: Float64Array; control: Float64Array };
    /** u' (nu) under the forces of the model and tau (nu) on the joints. */
    forwardDynamics(q: Numbers, u: Numbers, tau?: Numbers | null, out?: Float64Array, t?: number): Float64Array;
    /** Forces on the joints (nu) with which u' is as given. */
    inverseDynamics(q: Numbers, u: Numbers, udot: Numbers, out?: Float64Array, t?: number): Float64Array;
    /** Forward dynamics of states one behind the other. */
    batch(q: Numbers, u: Numbers, tau?: Numbers | null, t?: number): Float64Array;
    /** nu x nu */
    massMatrix(q: Numbers, t?: number): Float64Array;
    energy(q: Numbers, u: Numbers, t?: number): Energy;
    /** 12 numbers a body: its axes by columns, then its origin, m. */
    poses(q: Numbers, out?: Float64Array, t?: number): Float64Array;
    /** Of each body how many rates its joint has, and how many of them move mass. */
    ranks(q: Numbers, u?: Numbers, t?: number): { rates: number; rank: number }[];
    /** Oscillations about the consistent state near q (default: the start) and u (default: rest), slowest first. For
     * models of 400 coordinates and momenta at most: it costs their cube. */
    modes(q?: Numbers, u?: Numbers, t?: number): Mode[];
    report(q?: Numbers, u?: Numbers): Report;
    reportText(q?: Numbers, u?: Numbers): string;
    /** A model with other values of parameters, by their names; this one stays as it is. */
    with(values: Record<string, number>): Model;
    simulate(options?: RunOptions): Run;
    stepper(options?: StepperOptions): Stepper;
    /** The data of the page of `mbsrank view`, as JSON. */
    page(q?: Numbers, u?: Numbers): string;
    close(): void;
    [Symbol.dispose](): void;
}

export interface State {
    /** s */
    t: number;
    q: Float64Array;
    u: Float64Array;
    udot: Float64Array;
    /** Loop forces, one a row of the closures. */
    lambda: Float64Array;
}

export interface Stats {
    steps: number;
    residuals: number;
    newtonIterations: number;
    newtonFailures: number;
    errorTestFailures: number;
    factorisations: number;
    solves: number;
    /** s */
    lastStep: number;
}

/** A run whose steps the driver chooses; the state is the last one reached. */
export class Run implements Closing, State {
    readonly t: number;
    readonly q: Float64Array;
    readonly u: Float64Array;
    readonly udot: Float64Array;
    readonly lambda: Float64Array;
    readonly energy: Energy;
    readonly stats: Stats;
    readonly closed: boolean;
    /** On to a time, s; after a failure the state is the last good one. */
    to(t: number): this;
    states(times: Iterable<number>): Generator<State>;
    poses(out?: Float64Array): Float64Array;
    close(): void;
    [Symbol.dispose](): void;
}

/** Steps of fixed size, for real time. */
export class Stepper implements Closing {
    readonly t: number;
    readonly q: Float64Array;
    readonly u: Float64Array;
    readonly energy: Energy;
    readonly closed: boolean;
    /** `count` steps; where one is refused the state is that before it. */
    step(count?: number): this;
    /** Where the spring that pulls ends from now on, m. */
    drag(target: Numbers): void;
    poses(out?: Float64Array): Float64Array;
    close(): void;
    [Symbol.dispose](): void;
}
