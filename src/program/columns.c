/* Columns of a run: see columns.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/columns.h"

#include <stdlib.h>
#include <string.h>

static bool add(columns *c, column new)
{
    column *list = realloc(c->list, ((size_t)c->count + 1) * sizeof *list);
    if (!list) return false;
    c->list = list;
    list[c->count++] = new;
    return true;
}

/* Of number l of its q, or of its u with `rate`. */
static const char *joint_unit(mbsr_file_joint_kind kind, int l, bool rate)
{
    const bool ball = kind == MBSR_FILE_BALL, free = kind == MBSR_FILE_FREE;
    const bool length = kind == MBSR_FILE_SLIDE || (free && l >= (rate ? 3 : 4));
    if (!rate && !length && (ball || free)) return "1";
    if (length) return rate ? "m/s" : "m";
    return rate ? "rad/s" : "rad";
}

/* q, or u with `rate`, of joint number k. */
static bool add_joint(const program_model *m, int k, bool rate, columns *c)
{
    static const char *const parts[] = {"w", "x", "y", "z"}, *const free_q[] = {"w", "x",  "y",
                                                                                "z", "px", "py",
                                                                                "pz"},
                             *const free_u[] = {"wx", "wy", "wz", "vx", "vy", "vz"};
    const mbsr_file_joint *j = m->file->joint + k;
    const bool ball = j->kind == MBSR_FILE_BALL, free = j->kind == MBSR_FILE_FREE;
    const int n = ball ? (rate ? 3 : 4) : free ? (rate ? 6 : 7) : 1;
    int q, u;
    mbsr_body_coordinates(m->model, j->body, &q, NULL, &u, NULL);
    for (int l = 0; l < n; ++l) {
        column new = {.kind = rate ? COLUMN_U : COLUMN_Q,
                      .unit = joint_unit(j->kind, l, rate),
                      .at = rate ? u + j->coordinate + l : q + j->position + l};
        const char *part = free ? (rate ? free_u : free_q)[l] : parts[rate ? l + 1 : l],
                   *name = j->name[0] ? j->name : "joint";
        snprintf(new.name, sizeof new.name, "%.150s%s%s%s", name, rate ? ".rate" : "",
                 n > 1 ? "." : "", n > 1 ? part : "");
        if (!add(c, new)) return false;
    }
    return true;
}

static bool add_joints(const program_model *m, bool rate, columns *c)
{
    for (int k = 0; k < m->file->joints; ++k) {
        if (!add_joint(m, k, rate, c)) return false;
    }
    return true;
}

static bool add_position(int body, const double point[3], const char *name, columns *c)
{
    for (int l = 0; l < 3; ++l) {
        column new = {.kind = COLUMN_POSITION, .unit = "m", .at = body, .part = l};
        for (int k = 0; point && k < 3; ++k) new.point[k] = point[k];
        snprintf(new.name, sizeof new.name, "%.150s.%c", name, "xyz"[l]);
        if (!add(c, new)) return false;
    }
    return true;
}

/* By the name of the sensor. */
static bool add_sensor(const program_model *m, int k, columns *c)
{
    const mbsr_file_sensor *sensor = m->file->sensor + k;
    const int before = c->count;
    if (sensor->kind == MBSR_SENSOR_POINT)
        return add_position(sensor->body, sensor->point, sensor->name, c);
    if (!add_joint(m, sensor->joint, sensor->kind == MBSR_SENSOR_RATE, c)) return false;
    snprintf(c->list[before].name, sizeof c->list[before].name, "%.150s", sensor->name);
    return true;
}

static bool ends_with(char *name, const char *ending)
{
    const size_t length = strlen(name), tail = strlen(ending);
    if (length <= tail || strcmp(name + length - tail, ending) != 0) return false;
    name[length - tail] = '\0';
    return true;
}

static int add_name(const program_model *m, const char *given, columns *c)
{
    char name[200];
    bool good;
    snprintf(name, sizeof name, "%.190s", given);
    int joint = mbsr_file_find_joint(m->file, name);
    if (strcmp(name, "state") == 0) {
        good = add_joints(m, false, c) && add_joints(m, true, c);
    } else if (strcmp(name, "energy") == 0) {
        good = add(c, (column){.name = "kinetic", .unit = "J", .kind = COLUMN_KINETIC}) &&
               add(c, (column){.name = "potential", .unit = "J", .kind = COLUMN_POTENTIAL});
    } else if (joint >= 0) {
        good = add_joint(m, joint, false, c);
    } else if (mbsr_file_find_sensor(m->file, name) >= 0) {
        good = add_sensor(m, mbsr_file_find_sensor(m->file, name), c);
    } else if (ends_with(name, ".rate")) {
        joint = mbsr_file_find_joint(m->file, name);
        if (joint < 0) return complain(USAGE, "--output: there is no joint '%s'", name);
        good = add_joint(m, joint, true, c);
    } else if (ends_with(name, ".pos")) {
        const int body = mbsr_model_find_body(m->model, name);
        if (body < 0) return complain(USAGE, "--output: there is no body '%s'", name);
        good = add_position(body, NULL, given, c);
    } else {
        return complain(USAGE, "--output: there is no joint '%s'", name);
    }
    return good ? DONE : complain(FAILED, "no memory");
}

int columns_make(const program_model *m, const char *names, columns *c)
{
    int code = DONE;
    *c = (columns){.list = NULL};
    if (!names && !add_joints(m, false, c)) return complain(FAILED, "no memory");
    while (names && !code) {
        const size_t length = strcspn(names, ",");
        char name[200];
        snprintf(name, sizeof name, "%.*s", (int)(length < 190 ? length : 190), names);
        code = add_name(m, name, c);
        names = names[length] ? names + length + 1 : NULL;
    }
    return code;
}

void columns_head(const columns *c, FILE *to)
{
    fputs("t", to);
    for (int k = 0; k < c->count; ++k) {
        /* in quotes where a comma or a quote is part of it */
        if (!strpbrk(c->list[k].name, ",\"\n")) {
            fprintf(to, ",%s", c->list[k].name);
            continue;
        }
        fputs(",\"", to);
        for (const char *s = c->list[k].name; *s; ++s) fprintf(to, *s == '"' ? "\"\"" : "%c", *s);
        fputc('"', to);
    }
    fputc('\n', to);
}

/* One coordinate of a point of a body. */
static double place_of(const double pose[MBSR_POSE_SIZE], const column *of)
{
    double x = pose[MBSR_POSE_X + of->part];
    for (int k = 0; k < 3; ++k) x += pose[MBSR_POSE_R + 3 * k + of->part] * of->point[k];
    return x;
}

int columns_values(const columns *c, const mbsr_model *model, mbsr_data *data, const double *q,
                   const double *u, double *value)
{
    double kinetic = 0.0, potential = 0.0, pose[MBSR_POSE_SIZE];
    int status = MBSR_OK;
    for (int k = 0; k < c->count && !status; ++k) {
        if (c->list[k].kind < COLUMN_KINETIC) continue;
        status = mbsr_energy(model, data, &kinetic, &potential);
        break;
    }
    for (int k = 0; k < c->count && !status; ++k) {
        const column *one = c->list + k;
        value[k] = one->kind == COLUMN_KINETIC ? kinetic : potential;
        if (one->kind == COLUMN_Q) value[k] = q[one->at];
        if (one->kind == COLUMN_U) value[k] = u[one->at];
        if (one->kind == COLUMN_POSITION) {
            status = one->at == MBSR_GROUND ? MBSR_OK : mbsr_body_pose(model, data, one->at, pose);
            value[k] = one->at == MBSR_GROUND ? one->point[one->part] : place_of(pose, one);
        }
    }
    return status ? complain(FAILED, "%s", mbsr_data_error(data)->text) : DONE;
}
