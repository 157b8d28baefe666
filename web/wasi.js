// What the module asks of a system (WASI): files that the host shows by their names, and texts that it writes.
// SPDX-License-Identifier: BSD-3-Clause

const GOOD = 0, BADF = 8, NOENT = 44, NOTSUP = 58;
const FILE = 4, FOLDER = 3, ROOT = 3;

// `find(path)` gives the bytes of a file, or undefined; `written` is what has been written to standard error since it
// was taken last.
export class Wasi {
    constructor(find) {
        this.find = find;
        this.written = "";
        this.open = new Map();
        this.next = ROOT + 1;
        this.decoder = new TextDecoder();
    }

    take() {
        const text = this.written;
        this.written = "";
        return text;
    }

    #view() {
        return new DataView(this.memory.buffer);
    }

    #text(at, length) {
        return this.decoder.decode(new Uint8Array(this.memory.buffer, at, length));
    }

    #stat(at, kind, size) {
        const view = this.#view();
        for (let k = 0; k < 64; k += 8) view.setBigUint64(at + k, 0n, true);
        view.setUint8(at + 16, kind);
        view.setBigUint64(at + 24, 1n, true);
        view.setBigUint64(at + 32, BigInt(size), true);
        return GOOD;
    }

    // Calls `part(at, length)` for each piece of memory of a list.
    #each(list, count, part) {
        const view = this.#view();
        for (let k = 0; k < count; ++k) {
            const wanted = view.getUint32(list + 8 * k + 4, true);
            if (part(view.getUint32(list + 8 * k, true), wanted) < wanted) break;
        }
    }

    #read(fd, list, count, done) {
        const file = this.open.get(fd);
        if (!file) return BADF;
        let all = 0;
        this.#each(list, count, (at, length) => {
            const bytes = file.bytes.subarray(file.at, file.at + length);
            new Uint8Array(this.memory.buffer, at, bytes.length).set(bytes);
            file.at += bytes.length;
            all += bytes.length;
            return bytes.length;
        });
        this.#view().setUint32(done, all, true);
        return GOOD;
    }

    #write(fd, list, count, done) {
        let all = 0;
        if (fd > 2) return BADF;
        this.#each(list, count, (at, length) => {
            if (fd === 2) this.written += this.#text(at, length);
            all += length;
            return length;
        });
        this.#view().setUint32(done, all, true);
        return GOOD;
    }

    #openPath(path, to) {
        const bytes = this.find(path);
        if (!bytes) return NOENT;
        this.open.set(this.next, { bytes, at: 0 });
        this.#view().setUint32(to, this.next++, true);
        return GOOD;
    }

    #seek(fd, offset, whence, to) {
        const file = this.open.get(fd);
        if (!file) return BADF;
        file.at = Number(offset) + [0, file.at, file.bytes.length][whence];
        this.#view().setBigUint64(to, BigInt(file.at), true);
        return GOOD;
    }

    #describe(fd, to) {
        if (fd > ROOT && !this.open.has(fd)) return BADF;
        const view = this.#view();
        for (let k = 0; k < 24; k += 8) view.setBigUint64(to + k, 0n, true);
        view.setUint8(to, fd === ROOT ? FOLDER : fd < ROOT ? 2 : FILE);
        view.setBigUint64(to + 8, 0xffffffffffffffffn, true);
        view.setBigUint64(to + 16, 0xffffffffffffffffn, true);
        return GOOD;
    }

    #statPath(path, to) {
        const bytes = this.find(path);
        return bytes ? this.#stat(to, FILE, bytes.length) : NOENT;
    }

    #now(to) {
        this.#view().setBigUint64(to, BigInt(Math.round(1e6 * performance.now())), true);
        return GOOD;
    }

    #preopen(fd, to) {
        if (fd !== ROOT) return BADF;
        this.#view().setBigUint64(to, 1n << 32n, true); // a folder whose name has one letter
        return GOOD;
    }

    imports() {
        const none = () => NOTSUP, sizes = (a, b) => {
            this.#view().setUint32(a, 0, true);
            this.#view().setUint32(b, 0, true);
            return GOOD;
        };
        const known = {
            args_sizes_get: sizes,
            environ_sizes_get: sizes,
            args_get: () => GOOD,
            environ_get: () => GOOD,
            clock_time_get: (clock, precision, to) => this.#now(to),
            fd_close: (fd) => (this.open.delete(fd) ? GOOD : BADF),
            fd_fdstat_get: (fd, to) => this.#describe(fd, to),
            fd_fdstat_set_flags: () => GOOD,
            fd_filestat_get: (fd, to) => (this.open.has(fd) ? this.#stat(to, FILE, this.open.get(fd).bytes.length) : BADF),
            fd_prestat_get: (fd, to) => this.#preopen(fd, to),
            fd_prestat_dir_name: (fd, at) => (new Uint8Array(this.memory.buffer)[at] = 0x2f, GOOD),
            fd_read: (fd, list, count, done) => this.#read(fd, list, count, done),
            fd_seek: (fd, offset, whence, to) => this.#seek(fd, offset, whence, to),
            fd_write: (fd, list, count, done) => this.#write(fd, list, count, done),
            path_filestat_get: (fd, flags, at, length, to) => this.#statPath(this.#text(at, length), to),
            path_open: (fd, look, at, length, flags, rights, inherited, fdflags, to) =>
                this.#openPath(this.#text(at, length), to),
            random_get: (at, length) => (crypto.getRandomValues(new Uint8Array(this.memory.buffer, at, length)), GOOD),
            proc_exit: (code) => {
                throw new Error(`the module has ended with ${code}`);
            },
        };
        return new Proxy(known, { get: (all, name) => all[name] ?? none });
    }
}
