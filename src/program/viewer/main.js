// The page of `mbsrank view`.
// SPDX-License-Identifier: BSD-3-Clause
import { show } from "./app.js";
import { readData } from "./data.js";
import { $ } from "./dom.js";

readData($("data").textContent).then((data) => show(data));
