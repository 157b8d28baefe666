/* Whatever bytes the reader of files gets, it reads or refuses them, and what it reads can be
 * finished or is refused. For libFuzzer (option MBSR_FUZZ); tests/files/test_damaged.c calls it,
 * too.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fuzz_files.h"

#include <mbsrank/files.h>
#include <mbsrank/mbsrank.h>

#include <stdlib.h>
#include <string.h>

/* What was read, which other files are as well, but for parts. */
typedef struct given {
    const char *text;
    size_t size;
} given;

static int load(void *user, const char *path, const char **text, size_t *size)
{
    static const char *const parts[2][2] = {
        {"fuzz/part.xml", "<mujoco><worldbody><body name='o'><joint/></body></worldbody></mujoco>"},
        {"fuzz/part.sdf", "<sdf version='1.8'><model name='x'><link name='f'/></model></sdf>"}};
    const given *g = user;
    *text = g->text;
    *size = g->size;
    for (int k = 0; k < 2; ++k)
        if (strcmp(path, parts[k][0]) == 0) *text = parts[k][1], *size = strlen(parts[k][1]);
    return 0;
}

static int ends_well(const mbsr_file *file)
{
    mbsr_data *data;
    if (mbsr_model_finish(file->model)) return 0;
    if (mbsr_model_nq(file->model) != file->nq || mbsr_model_nu(file->model) != file->nu) abort();
    if (mbsr_model_bodies(file->model) > 200) return 0;
    if (mbsr_data_create(file->model, &data, NULL)) return 0;
    if (!mbsr_stage_positions(file->model, data, 0.0, file->q0) && file->bodies > 0) {
        double pose[MBSR_POSE_SIZE];
        (void)mbsr_body_pose(file->model, data, 0, pose);
    }
    mbsr_data_destroy(data);
    return 1;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    given g = {(const char *)bytes, size};
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_file *file;
    mbsr_error error;
    opt.load = load;
    opt.user = &g;
    opt.stop_stiffness = 10.0;
    opt.slip = 1e-3;
    const int status = mbsr_file_read(g.text, size, "fuzz/file.xml", &opt, &file, &error);
    if (status) {
        if (file || error.status != status || !error.text[0]) abort();
        return 0;
    }
    (void)ends_well(file);
    mbsr_file_destroy(file);
    return 0;
}
