/* All memory from the caller: a static pool for the model, a static block for the data. No malloc.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/mbsrank.h>

#include <stdio.h>

/* A pool that only grows: models are built once and kept. */
typedef struct pool {
    size_t used;
    _Alignas(64) unsigned char memory[1 << 16];
} pool;

static void *pool_allocate(void *user, size_t size)
{
    pool *p = user;
    const size_t rounded = (size + 63) / 64 * 64;
    if (rounded > sizeof p->memory - p->used) return NULL;
    p->used += rounded;
    return p->memory + p->used - rounded;
}

static void pool_release(void *user, void *memory)
{
    (void)user, (void)memory;
}

static pool model_pool;
static _Alignas(MBSR_DATA_ALIGNMENT) unsigned char block[1 << 16];

int main(void)
{
    mbsr_error error;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = (mbsr_allocator){pool_allocate, pool_release, &model_pool};
    if (mbsr_model_create(&def, &m, &error)) return 1;

    /* a planar chain: every other link has no mass */
    for (int k = 0; k < 8; ++k) {
        mbsr_body_def link = mbsr_default_body_def();
        link.parent = k - 1;
        link.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){k ? 0.5 : 0.0, 0.0, 0.0},
                                                (mbsr_planar_frame){0});
        if (k % 2) link.inertia = mbsr_inertia_planar(1.0, (double[2]){0.25, 0.0}, 0.02);
        if (mbsr_model_add_body(m, &link, NULL)) return 1;
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    if (mbsr_model_add_force(m, &gravity, NULL) || mbsr_model_finish(m)) return 1;

    /* a block that is too small is refused with the size that is needed */
    if (mbsr_data_init(m, block, 100, &d, &error) != MBSR_ERR_MEMORY_SIZE) return 1;
    printf("%s\n", error.text);
    if (mbsr_data_init(m, block, sizeof block, &d, &error)) return 1;

    double q[8], u[8] = {0}, a[8];
    for (int k = 0; k < 8; ++k) q[k] = 0.2 * k;
    if (mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, a)) {
        printf("%s\n", mbsr_data_error(d)->text);
        return 1;
    }
    printf("model: %zu bytes of the pool, data: %zu bytes; u' of the first link: %.4f rad/s^2\n",
           model_pool.used, mbsr_data_size(m), a[0]);
    return 0;
}
