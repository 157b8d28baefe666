/* Runs one piece of code of the documents: `code` has them all, by their numbers. Fails where a
 * call in it left an error.
 * SPDX-License-Identifier: BSD-3-Clause
 * Usage: program PIECE [unfinished] [planar] [xacro] [taken]
 *
 * The world is two arms of two links each, on springs and dampers, the last link a light one.
 * unfinished: the model can still be added to. planar: it lies in the plane. xacro: the text has
 * xacro in it. taken: the code gives the model away. */
#include "snippet_world.h"

#include <stdlib.h>
#include <string.h>

void code(int piece);

mbsr_model *m, *model;
mbsr_data *d, *data;
mbsr_newton *newton;
mbsr_body_def body;
mbsr_joint_table table;
mbsr_error error;
double t = 0.0, c = 100.0;
int status, n = 1;
void *user;
static double numbers[8][64];
double *q = numbers[0], *u = numbers[1], *y = numbers[2], *yp = numbers[3], *F = numbers[4],
       *delta = numbers[5];
const char *text = "<robot name='r'><link name='arm'/></robot>";
size_t size;

static const char with_xacro[] = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>"
                                 "<xacro:arg name='ur_type' default='x'/>"
                                 "<xacro:arg name='name' default='x'/>"
                                 "<link name='$(arg name)'/></robot>";

static mbsr_body_def link_of(int parent, double mass, int planar)
{
    const double tip[3] = {1, 0, 0}, z[3] = {0, 0, 1};
    const double tensor[6] = {0.1 * mass, 0.1 * mass, 0.1 * mass, 0, 0, 0};
    const double length = parent == MBSR_GROUND ? 0.0 : 1.0;
    const mbsr_planar_frame there = {length, 0, 0}, origin = {0, 0, 0};
    const mbsr_frame end = mbsr_frame_at(length, 0, 0);
    mbsr_body_def def = mbsr_default_body_def();
    def.parent = parent;
    def.joint =
        planar ? mbsr_joint_planar_revolute(there, origin) : mbsr_joint_revolute(&end, NULL, z);
    def.inertia =
        planar ? mbsr_inertia_planar(mass, tip, 0.1 * mass) : mbsr_inertia_rigid(mass, tip, tensor);
    return def;
}

static int build(int planar)
{
    const int parents[4] = {MBSR_GROUND, 0, MBSR_GROUND, 2};
    const double masses[4] = {1.0, 1.0, 1.0, 1e-4};
    int bad = mbsr_model_create(NULL, &model, &error);
    for (int k = 0; k < 4 && !bad; ++k) {
        mbsr_body_def link = link_of(parents[k], masses[k], planar);
        mbsr_force_def spring = mbsr_force_joint_spring(k, 0, 10.0, 1.0, 0.0);
        bad = mbsr_model_add_body(model, &link, NULL);
        if (!bad) bad = mbsr_model_add_force(model, &spring, NULL);
    }
    m = model;
    body = link_of(MBSR_GROUND, 1.0, planar);
    return bad;
}

static int finish(void)
{
    mbsr_newton_opt with_products = mbsr_default_newton_opt();
    int bad = mbsr_model_finish(model);
    with_products.products = with_products.transposes = 1;
    if (!bad) bad = mbsr_data_create(model, &data, &error);
    d = data;
    q[0] = 0.3;
    if (!bad) bad = mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, t, q, u, y);
    if (!bad) bad = mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, t, y, yp, NULL, NULL);
    if (!bad) bad = mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &with_products, &newton, &error);
    if (!bad) bad = mbsr_newton_factor(newton, data, t, y, yp, c);
    return bad;
}

static int failed(const char *what, const char *why)
{
    printf("%s: %s\n", what, why);
    return 1;
}

int main(int argc, char **argv)
{
    int unfinished = 0, planar = 0, taken = 0;
    for (int k = 2; k < argc; ++k) {
        if (!strcmp(argv[k], "unfinished")) unfinished = 1;
        if (!strcmp(argv[k], "planar")) planar = 1;
        if (!strcmp(argv[k], "taken")) taken = 1;
        if (!strcmp(argv[k], "xacro")) text = with_xacro;
    }
    size = strlen(text);
    if (build(planar) || (!unfinished && finish()))
        return failed("the world", error.text[0] ? error.text : mbsr_model_error(model)->text);
    code(argc > 1 ? atoi(argv[1]) : 0);
    if (status) return failed("status", mbsr_status_text(status));
    if (error.text[0]) return failed("error", error.text);
    if (!taken && mbsr_model_error(model)->text[0])
        return failed("model", mbsr_model_error(model)->text);
    if (data && mbsr_data_error(data)->text[0]) return failed("data", mbsr_data_error(data)->text);
    return 0;
}
