/* Time of reading generated files of URDF and MJCF.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_files [samples [bodies]]     CSV on standard output
 *   bench_files write urdf|mjcf [bodies]     the file itself
 *
 * A binary tree of bodies with names, inertias, one joint each with limits and damping, and a shape
 * that is drawn and one that touches, as robots have them; numbers of 5 to 8 digits, no meshes. A
 * sample is one mbsr_file_read of a text in memory: XML, the scene, and the model up to where it
 * would be finished. */
#include "bench.h"

#include <mbsrank/files.h>

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 9, BODIES = 20000, FORMATS = 2 };

static const char *const format_name[FORMATS] = {"urdf", "mjcf"};

typedef struct text {
    char *bytes;
    size_t size, room;
    uint64_t random;
} text;

static void put(text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void put(text *t, const char *format, ...)
{
    if (t->room - t->size < 1024) {
        t->room = 2 * t->room + 4096;
        t->bytes = realloc(t->bytes, t->room);
        bench_check(t->bytes == NULL, "memory", NULL);
    }
    va_list arguments;
    va_start(arguments, format);
    t->size += (size_t)vsnprintf(t->bytes + t->size, t->room - t->size, format, arguments);
    va_end(arguments);
}

/* A random number between -1 and 1. */
static double any(text *t)
{
    return bench_uniform(&t->random, -1.0, 1.0);
}

/* A positive one about `size`. */
static double some(text *t, double size)
{
    return size * bench_uniform(&t->random, 0.8, 1.2);
}

/* ---- URDF: a list of links, a list of joints ---- */

static void put_link(text *t, int k)
{
    put(t,
        "  <link name=\"link_%d\">\n    <inertial>\n      <origin xyz=\"%.5f %.5f %.5f\" rpy=\"0 0 "
        "0\"/>\n"
        "      <mass value=\"%.6f\"/>\n",
        k, 0.1 * any(t), 0.1 * any(t), 0.1 * any(t), some(t, 1.5));
    put(t,
        "      <inertia ixx=\"%.8f\" ixy=\"%.8f\" ixz=\"%.8f\" iyy=\"%.8f\" iyz=\"%.8f\" "
        "izz=\"%.8f\"/>\n"
        "    </inertial>\n",
        some(t, 0.01), 1e-4 * any(t), 1e-4 * any(t), some(t, 0.01), 1e-4 * any(t), some(t, 0.01));
    put(t,
        "    <visual>\n      <origin xyz=\"0 0 %.5f\" rpy=\"0 %.5f 0\"/>\n      <geometry>\n"
        "        <cylinder radius=\"%.4f\" length=\"%.4f\"/>\n      </geometry>\n"
        "      <material name=\"grey\"><color rgba=\"0.6 0.6 0.6 1\"/></material>\n    </visual>\n",
        0.1 * any(t), any(t), some(t, 0.04), some(t, 0.3));
    put(t,
        "    <collision>\n      <origin xyz=\"0 0 %.5f\"/>\n      <geometry>\n        <box "
        "size=\"%.4f %.4f "
        "%.4f\"/>\n      </geometry>\n    </collision>\n  </link>\n",
        0.1 * any(t), some(t, 0.1), some(t, 0.1), some(t, 0.3));
}

static void put_joint(text *t, int k)
{
    put(t,
        "  <joint name=\"joint_%d\" type=\"revolute\">\n    <parent link=\"link_%d\"/>\n"
        "    <child link=\"link_%d\"/>\n    <origin xyz=\"%.5f %.5f %.5f\" rpy=\"%.6f %.6f "
        "%.6f\"/>\n",
        k, (k - 1) / 2, k, any(t), any(t), any(t), any(t), any(t), any(t));
    put(t,
        "    <axis xyz=\"0 %d %d\"/>\n    <limit lower=\"%.5f\" upper=\"%.5f\" effort=\"100\" "
        "velocity=\"3.14\"/>\n    <dynamics damping=\"%.4f\" friction=\"0\"/>\n  </joint>\n",
        k % 2, 1 - k % 2, -some(t, 2.0), some(t, 2.0), some(t, 0.5));
}

static void write_urdf(text *t, int bodies)
{
    put(t, "<?xml version=\"1.0\"?>\n<robot name=\"tree\">\n");
    for (int k = 0; k < bodies; ++k) put_link(t, k);
    for (int k = 1; k < bodies; ++k) put_joint(t, k);
    put(t, "</robot>\n");
}

/* ---- MJCF: bodies in each other ---- */

static void put_body(text *t, int k, int bodies, int depth)
{
    const int in = 2 * depth + 4;
    put(t, "%*s<body name=\"link_%d\" pos=\"%.5f %.5f %.5f\" quat=\"%.6f %.6f %.6f %.6f\">\n", in,
        "", k, any(t), any(t), any(t), some(t, 1.0), any(t), any(t), any(t));
    put(t,
        "%*s<inertial pos=\"%.5f %.5f %.5f\" mass=\"%.6f\" fullinertia=\"%.8f %.8f %.8f %.8f %.8f "
        "%.8f\"/>\n",
        in + 2, "", 0.1 * any(t), 0.1 * any(t), 0.1 * any(t), some(t, 1.5), some(t, 0.01),
        some(t, 0.01), some(t, 0.01), 1e-4 * any(t), 1e-4 * any(t), 1e-4 * any(t));
    put(t, "%*s<joint name=\"joint_%d\" axis=\"0 %d %d\" range=\"%.5f %.5f\" damping=\"%.4f\"/>\n",
        in + 2, "", k, k % 2, 1 - k % 2, -some(t, 2.0), some(t, 2.0), some(t, 0.5));
    put(t, "%*s<geom class=\"visual\" type=\"cylinder\" pos=\"0 0 %.5f\" size=\"%.4f %.4f\"/>\n",
        in + 2, "", 0.1 * any(t), some(t, 0.04), some(t, 0.15));
    put(t, "%*s<geom class=\"collision\" type=\"box\" pos=\"0 0 %.5f\" size=\"%.4f %.4f %.4f\"/>\n",
        in + 2, "", 0.1 * any(t), some(t, 0.05), some(t, 0.05), some(t, 0.15));
    for (int next = 2 * k + 1; next <= 2 * k + 2 && next < bodies; ++next)
        put_body(t, next, bodies, depth + 1);
    put(t, "%*s</body>\n", in, "");
}

static void write_mjcf(text *t, int bodies)
{
    put(t,
        "<mujoco model=\"tree\">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  <default>\n"
        "    <joint armature=\"0.01\"/>\n    <default class=\"visual\"><geom contype=\"0\" "
        "conaffinity=\"0\" "
        "group=\"2\" rgba=\"0.6 0.6 0.6 1\"/></default>\n    <default class=\"collision\"><geom "
        "group=\"3\"/>"
        "</default>\n  </default>\n  <worldbody>\n");
    put_body(t, 0, bodies, 0);
    put(t, "  </worldbody>\n</mujoco>\n");
}

static text generate(int format, int bodies)
{
    text t = {.random = 1};
    (format == 0 ? write_urdf : write_mjcf)(&t, bodies);
    return t;
}

static double measure(void *context, int which)
{
    const text *t = (const text *)context + which;
    mbsr_file *file = NULL;
    mbsr_error error;
    const double start = bench_now();
    const int status = mbsr_file_read(t->bytes, t->size, format_name[which], NULL, &file, &error);
    const double time = bench_now() - start;
    bench_check(status, "reading", error.text);
    mbsr_file_destroy(file);
    return time;
}

int main(int argc, char **argv)
{
    if (argc > 2 && strcmp(argv[1], "write") == 0) {
        text t = generate(strcmp(argv[2], "mjcf") == 0, argc > 3 ? atoi(argv[3]) : BODIES);
        fwrite(t.bytes, 1, t.size, stdout);
        free(t.bytes);
        return 0;
    }
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES,
              bodies = argc > 2 ? atoi(argv[2]) : BODIES;
    text texts[FORMATS];
    double *time = bench_allocate((size_t)(FORMATS * samples), sizeof *time);
    for (int k = 0; k < FORMATS; ++k) texts[k] = generate(k, bodies);
    bench_sample_all(FORMATS, samples, measure, texts, time);
    bench_header(stdout, "time of reading generated files");
    printf("format,bodies,MB,ms,min,q1,q3,MB_per_s,bodies_per_s,samples\n");
    for (int k = 0; k < FORMATS; ++k) {
        const bench_quartiles t = bench_statistics(samples, time + k * samples);
        const double size = 1e-6 * (double)texts[k].size;
        printf("%s,%d,%.2f,%.1f,%.1f,%.1f,%.1f,%.1f,%.0f,%d\n", format_name[k], bodies, size,
               1e3 * t.median, 1e3 * t.min, 1e3 * t.q1, 1e3 * t.q3, size / t.median,
               bodies / t.median, samples);
        free(texts[k].bytes);
    }
    free(time);
    return 0;
}
