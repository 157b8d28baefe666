/* Journals of studies: see study.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A file for each process: a head, then runs one behind the other,
 *
 *   head   64 bytes: MAGIC, the number 1 as it lies in memory, numbers of a run, parameters, runs,
 *          key, checksum
 *   run    fixed part (run, outcome, status, steps, length of the text, checksum of these), numbers
 *          of the run if it is DONE, text, checksum of these two
 *
 * Checksums are FNV-1a of 64 bits. Each run is one call of write, so that a process that is killed
 * leaves all of it or a beginning, which the checksums show. */
#define _POSIX_C_SOURCE 200809L
#include "base/cookie.h"
#include "base/error.h"
#include "files/numbers.h"
#include "study/record.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char MAGIC[24] = "mbsrank journal 1\n";

typedef struct journal_head {
    char magic[24];
    uint32_t one, numbers;
    uint64_t parameters_runs; /* parameters in the upper 24 bits */
    uint64_t key, spare, check;
} journal_head;

typedef struct run_head {
    int64_t run;
    int32_t outcome, status;
    int64_t steps;
    uint64_t text; /* its length */
    uint64_t check;
} run_head;

/* Where a run stands. */
typedef struct run_place {
    int64_t offset; /* of its fixed part */
    int32_t file;   /* -1: nowhere */
    int32_t outcome;
} run_place;

enum { MOST_FILES = 65536, PATH_SIZE = 4096 };

struct mbsr_journal {
    mbsri_arena arena;
    const mbsr_study *study;
    const char *folder;
    uint64_t key;
    run_place *place;      /* runs */
    unsigned char *block;  /* a run as it is written */
    int writer, file;      /* number and descriptor of the file that is written; -1 */
    int64_t end;           /* of it */
    int reader, read_file; /* likewise of the one read last; -1 */
};

static uint64_t check_of(uint64_t before, const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    for (size_t k = 0; k < size; ++k) before = (before ^ at[k]) * UINT64_C(1099511628211);
    return before;
}

static uint64_t check_alone(const void *bytes, size_t size)
{
    return check_of(UINT64_C(14695981039346656037), bytes, size);
}

static void journal_path(const mbsr_journal *j, int number, char path[PATH_SIZE])
{
    mbsri_print(path, PATH_SIZE, "%s/%d.journal", j->folder, number);
}

/* Of a file in a folder of journals; -1: it is none of them. */
static int journal_number(const char *name)
{
    int number = 0;
    const char *at = name;
    for (; mbsri_is_digit(*at) && number < MOST_FILES; ++at) number = 10 * number + (*at - '0');
    return at > name && number < MOST_FILES && strcmp(at, ".journal") == 0 ? number : -1;
}

static int fail_file(mbsr_error *error, const char *path, const char *what)
{
    const int reason = errno;
    char text[128] = "";
    if (strerror_r(reason, text, sizeof text) != 0) text[0] = '\0';
    return mbsri_fail_plain(error, MBSR_ERR_FILE, "%s cannot be %s: %s", path, what, text);
}

/* ---- bytes in and out ---- */

/* What there was to read. */
typedef enum reading { WHOLE, CUT, UNREAD } reading;

/* CUT: the file ends before; UNREAD: it cannot be read, errno says why. */
static reading read_bytes(int file, void *to, size_t size, int64_t offset)
{
    unsigned char *at = to;
    while (size > 0) {
        const ssize_t part = pread(file, at, size, (off_t)offset);
        if (part < 0 && errno == EINTR) continue;
        if (part < 0) return UNREAD;
        if (part == 0) return CUT;
        at += part;
        offset += part;
        size -= (size_t)part;
    }
    return WHOLE;
}

static bool write_bytes(int file, const void *from, size_t size)
{
    const unsigned char *at = from;
    while (size > 0) {
        const ssize_t part = write(file, at, size);
        if (part < 0 && errno == EINTR) continue;
        if (part < 0) return false;
        at += part;
        size -= (size_t)part;
    }
    return true;
}

/* Behind the end of a file, which a failure leaves where it was. */
static bool append_bytes(mbsr_journal *j, const void *from, size_t size)
{
    if (lseek(j->file, (off_t)j->end, SEEK_SET) < 0) return false;
    if (write_bytes(j->file, from, size)) {
        j->end += (int64_t)size;
        return true;
    }
    const int reason = errno;
    const int cut = ftruncate(j->file, (off_t)j->end); /* else the checksums tell */
    (void)cut;
    errno = reason;
    return false;
}

/* ---- the head of a file ---- */

static journal_head head_of(const mbsr_journal *j)
{
    journal_head h = {.one = 1,
                      .numbers = (uint32_t)j->study->numbers,
                      .parameters_runs =
                          (uint64_t)j->study->parameters << 40 | (uint64_t)j->study->runs,
                      .key = j->key};
    memcpy(h.magic, MAGIC, sizeof h.magic);
    h.check = check_alone(&h, offsetof(journal_head, check));
    return h;
}

/* *size is how many bytes of it are there; 0: the file is empty or was cut within its head. */
static int check_head(const mbsr_journal *j, int file, const char *path, int64_t *size,
                      mbsr_error *error)
{
    const journal_head wanted = head_of(j);
    journal_head h;
    *size = 0;
    switch (read_bytes(file, &h, sizeof h, 0)) {
    case CUT: return MBSR_OK;
    case UNREAD: return fail_file(error, path, "read");
    case WHOLE: break;
    }
    *size = (int64_t)sizeof h;
    if (memcmp(&h, &wanted, sizeof h) == 0) return MBSR_OK;
    if (memcmp(h.magic, MAGIC, sizeof h.magic) != 0 || h.one != 1 ||
        h.check != check_alone(&h, offsetof(journal_head, check)))
        mbsri_fail_plain(error, MBSR_ERR_MISMATCH, "%s is no journal of a study, or damaged", path);
    else
        mbsri_fail_plain(error, MBSR_ERR_MISMATCH,
                         "%s belongs to another study: its file or its model has changed since",
                         path);
    return MBSR_ERR_MISMATCH;
}

/* ---- runs ---- */

/* Of a run that is there, and of one that comes, which one counts. */
static bool counts_more(int32_t there, int32_t comes)
{
    return there == MBSR_RUN_MISSING || (there == MBSR_RUN_TIME && comes != MBSR_RUN_TIME);
}

static size_t payload_of(const mbsr_journal *j, const run_head *h)
{
    const size_t numbers = h->outcome == MBSR_RUN_DONE ? (size_t)j->study->numbers : 0;
    return numbers * sizeof(double) + (size_t)h->text;
}

/* The run at an offset; CUT: there is none, or not all of it. Its payload is in the block. */
static reading read_run(const mbsr_journal *j, int file, int64_t offset, run_head *h)
{
    uint64_t check;
    reading there = read_bytes(file, h, sizeof *h, offset);
    if (there != WHOLE) return there;
    if (h->check != check_alone(h, offsetof(run_head, check))) return CUT;
    if (h->run < 0 || h->run >= j->study->runs || h->text >= MBSR_TEXT_SIZE || h->outcome < 0 ||
        h->outcome >= MBSR_RUN_MISSING)
        return CUT;
    const size_t size = payload_of(j, h);
    there = read_bytes(file, j->block, size + sizeof check, offset + (int64_t)sizeof *h);
    if (there != WHOLE) return there;
    memcpy(&check, j->block + size, sizeof check);
    return check == check_alone(j->block, size) ? WHOLE : CUT;
}

/* Notes the runs of file `number`; *end is behind the last whole one. False: what is there cannot
 * be read. */
static bool note_runs(mbsr_journal *j, int file, int number, int64_t *end)
{
    run_head h;
    reading there;
    while ((there = read_run(j, file, *end, &h)) == WHOLE) {
        run_place *place = j->place + h.run;
        if (counts_more(place->outcome, h.outcome))
            *place = (run_place){.offset = *end, .file = number, .outcome = h.outcome};
        *end += (int64_t)(sizeof h + payload_of(j, &h) + sizeof h.check);
    }
    return there == CUT;
}

/* ---- opening ---- */

mbsr_journal_opt mbsr_default_journal_opt(void)
{
    return (mbsr_journal_opt){.cookie = MBSRI_COOKIE, .folder = NULL};
}

static mbsr_journal *make_journal(const mbsr_journal_opt *opt, const mbsr_study *study)
{
    mbsri_arena arena;
    mbsri_arena_open(&arena, &opt->allocator);
    mbsr_journal *j = mbsri_arena_take(&arena, sizeof *j);
    const size_t numbers = (size_t)study->numbers * sizeof(double),
                 block = sizeof(run_head) + numbers + MBSR_TEXT_SIZE + sizeof(uint64_t);
    run_place *place = mbsri_arena_take(&arena, (size_t)study->runs * sizeof *place);
    unsigned char *bytes = mbsri_arena_take(&arena, block);
    char *folder = mbsri_arena_text(&arena, opt->folder, strlen(opt->folder));
    if (!j || !place || !bytes || !folder) {
        mbsri_arena_close(&arena);
        return NULL;
    }
    *j = (mbsr_journal){.arena = arena,
                        .study = study,
                        .folder = folder,
                        .key = opt->key,
                        .place = place,
                        .block = bytes,
                        .writer = opt->writer,
                        .file = -1,
                        .reader = -1,
                        .read_file = -1};
    for (long k = 0; k < study->runs; ++k)
        place[k] = (run_place){.file = -1, .outcome = MBSR_RUN_MISSING};
    return j;
}

/* Reads file `number`, or makes it where it is to be written. */
static int read_one(mbsr_journal *j, int number, mbsr_error *error)
{
    char path[PATH_SIZE];
    journal_path(j, number, path);
    const bool writes = number == j->writer;
    const int file = open(path, writes ? O_RDWR | O_CREAT : O_RDONLY, 0666);
    if (file < 0) return fail_file(error, path, writes ? "written" : "read");
    int64_t end;
    int status = check_head(j, file, path, &end, error);
    if (!status && end > 0 && !note_runs(j, file, number, &end))
        status = fail_file(error, path, "read");
    if (!writes || status) {
        close(file);
        return status;
    }
    j->file = file;
    j->end = end;
    if (ftruncate(file, (off_t)end) != 0) status = fail_file(error, path, "written");
    const journal_head h = head_of(j);
    if (!status && end == 0 && !append_bytes(j, &h, sizeof h))
        status = fail_file(error, path, "written");
    return status;
}

/* Reads what other writers have left. */
static int read_folder(mbsr_journal *j, mbsr_error *error)
{
    DIR *folder = opendir(j->folder);
    int status = MBSR_OK;
    if (!folder && errno == ENOENT && j->writer < 0) return MBSR_OK;
    if (!folder) return fail_file(error, j->folder, "read");
    for (;;) {
        errno = 0;
        const struct dirent *entry = status ? NULL : readdir(folder);
        if (!entry) break;
        char path[PATH_SIZE], own[PATH_SIZE];
        const int number = journal_number(entry->d_name);
        if (number < 0 || number == j->writer) continue;
        journal_path(j, number, path);
        mbsri_print(own, sizeof own, "%s/%s", j->folder, entry->d_name);
        if (strcmp(path, own) == 0) status = read_one(j, number, error);
    }
    if (!status && errno) status = fail_file(error, j->folder, "read");
    closedir(folder);
    return status;
}

int mbsr_journal_open(const mbsr_journal_opt *opt, const mbsr_study *study, mbsr_journal **journal,
                      mbsr_error *error)
{
    if (journal) *journal = NULL;
    if (!opt || !study || !journal)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "opt, study or journal is NULL");
    if (opt->cookie != MBSRI_COOKIE)
        return mbsri_fail_plain(error, MBSR_ERR_NO_DEFAULT,
                                "opt was not made by mbsr_default_journal_opt");
    if (!opt->folder) return mbsri_fail_plain(error, MBSR_ERR_NULL, "opt.folder is NULL");
    if (opt->writer < -1 || opt->writer >= MOST_FILES || strlen(opt->folder) > PATH_SIZE - 32)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "opt.writer is %d, or opt.folder too long",
                                opt->writer);
    if (opt->writer >= 0 && mkdir(opt->folder, 0777) != 0 && errno != EEXIST)
        return fail_file(error, opt->folder, "made");
    mbsr_journal *j = make_journal(opt, study);
    if (!j) return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "no memory");
    int status = read_folder(j, error);
    if (!status && j->writer >= 0) status = read_one(j, j->writer, error);
    if (status)
        mbsr_journal_close(j, 0);
    else
        *journal = j;
    return status;
}

int mbsr_journal_close(mbsr_journal *j, int sync)
{
    int status = MBSR_OK;
    if (!j) return MBSR_OK;
    if (j->file >= 0 && sync && fsync(j->file) != 0) status = MBSR_ERR_FILE;
    if (j->file >= 0 && close(j->file) != 0) status = MBSR_ERR_FILE;
    if (j->read_file >= 0) close(j->read_file);
    mbsri_arena arena = j->arena; /* which holds the journal */
    mbsri_arena_close(&arena);
    return status;
}

/* ---- adding and asking ---- */

int mbsr_journal_add(mbsr_journal *j, const mbsr_study_result *result, mbsr_error *error)
{
    if (!j || !result || (result->outcome == MBSR_RUN_DONE && !result->value))
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "journal, result or its value is NULL");
    if (result->run < 0 || result->run >= j->study->runs)
        return mbsri_fail_plain(error, MBSR_ERR_ID, "there is no run %ld", result->run);
    if (result->outcome < MBSR_RUN_DONE || result->outcome >= MBSR_RUN_MISSING)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "run %ld: outcome %d is none", result->run,
                                (int)result->outcome);
    if (j->file < 0) return mbsri_fail_plain(error, MBSR_ERR_SEQUENCE, "the journal has no writer");
    const char *text = result->text ? result->text : "";
    const size_t length = strnlen(text, MBSR_TEXT_SIZE - 1);
    run_head h = {.run = result->run,
                  .outcome = (int32_t)result->outcome,
                  .status = result->status,
                  .steps = result->steps,
                  .text = length};
    h.check = check_alone(&h, offsetof(run_head, check));
    const size_t size = payload_of(j, &h), numbers = size - length;
    unsigned char *at = j->block;
    memcpy(at, &h, sizeof h);
    at += sizeof h;
    if (numbers > 0) memcpy(at, result->value, numbers);
    memcpy(at + numbers, text, length);
    const uint64_t check = check_alone(at, size);
    memcpy(at + size, &check, sizeof check);
    const int64_t offset = j->end;
    if (!append_bytes(j, j->block, sizeof h + size + sizeof check)) {
        char path[PATH_SIZE];
        journal_path(j, j->writer, path);
        return fail_file(error, path, "written");
    }
    run_place *place = j->place + h.run;
    if (counts_more(place->outcome, h.outcome))
        *place = (run_place){.offset = offset, .file = j->writer, .outcome = h.outcome};
    return MBSR_OK;
}

mbsr_outcome mbsr_journal_outcome(const mbsr_journal *j, long run)
{
    return j && run >= 0 && run < j->study->runs ? (mbsr_outcome)j->place[run].outcome
                                                 : MBSR_RUN_MISSING;
}

int mbsr_journal_has(const mbsr_journal *j, long run)
{
    const mbsr_outcome outcome = mbsr_journal_outcome(j, run);
    return outcome != MBSR_RUN_MISSING && outcome != MBSR_RUN_TIME;
}

/* The descriptor of file `number`; -1: it cannot be opened. */
static int descriptor(mbsr_journal *j, int number, char path[PATH_SIZE])
{
    journal_path(j, number, path);
    if (number == j->writer) return j->file;
    if (number != j->reader) {
        if (j->read_file >= 0) close(j->read_file);
        j->read_file = open(path, O_RDONLY);
        j->reader = j->read_file >= 0 ? number : -1;
    }
    return j->read_file;
}

int mbsr_journal_get(mbsr_journal *j, long run, double *value, char *text,
                     mbsr_study_result *result, mbsr_error *error)
{
    if (!j || !value || !text || !result)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "journal, value, text or result is NULL");
    if (run < 0 || run >= j->study->runs)
        return mbsri_fail_plain(error, MBSR_ERR_ID, "there is no run %ld", run);
    const run_place *place = j->place + run;
    *text = '\0';
    *result =
        (mbsr_study_result){.run = run, .outcome = MBSR_RUN_MISSING, .value = value, .text = text};
    for (int k = 0; k < j->study->numbers; ++k) value[k] = NAN;
    if (place->file < 0) return MBSR_OK;
    char path[PATH_SIZE];
    run_head h;
    const int file = descriptor(j, place->file, path);
    if (file < 0) return fail_file(error, path, "read");
    const reading there = read_run(j, file, place->offset, &h);
    if (there == UNREAD) return fail_file(error, path, "read");
    if (there == CUT || h.run != run)
        return mbsri_fail_plain(error, MBSR_ERR_FILE, "%s has changed: run %ld is not there", path,
                                run);
    const size_t numbers = payload_of(j, &h) - (size_t)h.text;
    if (numbers > 0) memcpy(value, j->block, numbers);
    memcpy(text, j->block + numbers, (size_t)h.text);
    text[h.text] = '\0';
    result->outcome = (mbsr_outcome)h.outcome;
    result->status = h.status;
    result->steps = (long)h.steps;
    return MBSR_OK;
}
