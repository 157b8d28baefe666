// The thread in which a model of the page runs: it answers each call with where the model is then.
// SPDX-License-Identifier: BSD-3-Clause
import { Library } from "mbsrank";
import { Runner } from "./runner.js";

let runner, broken; // broken: why there is none

function call(name, args) {
    if (name === "open") runner = new Runner(new Library(args[0]).read(...args.slice(1)));
    else return runner[name](...args);
    return undefined;
}

onmessage = ({ data: { name, args, epoch } }) => {
    const answer = { name, epoch, trouble: name === "advance" ? undefined : "" };
    try {
        answer.rate = call(name, args);
    } catch (error) {
        if (name === "open") broken = error.message;
        answer.trouble = broken ?? error.message;
    }
    const stepper = runner?.stepper;
    if (stepper) Object.assign(answer, runner.state, { poses: stepper.poses(), pulled: runner.pull !== undefined });
    postMessage(answer, stepper ? [answer.q.buffer, answer.u.buffer, answer.poses.buffer] : []);
};
