/* Columns of a run: see columns.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/columns.h"

#include <stdlib.h>
#include <string.h>

static bool append_column(columns *c, column new)
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
static bool add_joint_column(const program_model *m, int k, bool rate, columns *c)
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
        if (!append_column(c, new)) return false;
    }
    return true;
}

static bool add_joint_columns(const program_model *m, bool rate, columns *c)
{
    for (int k = 0; k < m->file->joints; ++k) {
        if (!add_joint_column(m, k, rate, c)) return false;
    }
    return true;
}

static bool add_position(int body, const char *name, columns *c)
{
    for (int l = 0; l < 3; ++l) {
        column new = {.kind = COLUMN_POSITION, .unit = "m", .at = body, .part = l};
        snprintf(new.name, sizeof new.name, "%.150s.%c", name, "xyz"[l]);
        if (!append_column(c, new)) return false;
    }
    return true;
}

/* The force on a body, and where it acts. */
static bool add_contact(int body, int other, const char *name, columns *c)
{
    static const char *const parts[] = {"x", "y", "z", "px", "py", "pz"};
    for (int l = 0; l < 6; ++l) {
        column new = {.kind = COLUMN_CONTACT,
                      .unit = l < 3 ? "N" : "m",
                      .at = body,
                      .part = l,
                      .other = other};
        snprintf(new.name, sizeof new.name, "%.180s.contact.%s", name, parts[l]);
        if (!append_column(c, new)) return false;
    }
    return true;
}

static bool add_all_contacts(const program_model *m, columns *c)
{
    for (int body = 0; body < m->file->bodies; ++body) {
        bool touches = false;
        for (int k = 0; k < m->file->shapes; ++k)
            touches = touches || (m->file->shape[k].contact && m->file->shape[k].body == body);
        const char *name = m->file->body_name[body];
        if (touches && !add_contact(body, ANY_BODY, name[0] ? name : "body", c)) return false;
    }
    return true;
}

/* MBSR_GROUND of `world`; MBSR_NONE: there is none of that name. */
static int contact_body(const program_model *m, const char *name)
{
    if (strcmp(name, "world") == 0) return MBSR_GROUND;
    const int body = mbsr_model_find_body(m->model, name);
    return body < 0 ? MBSR_NONE : body;
}

/* A body, or two with a colon between them. A code. */
static int add_named_contact(const program_model *m, const char *given, columns *c)
{
    char name[200];
    snprintf(name, sizeof name, "%s", given);
    int body = contact_body(m, name), other = ANY_BODY;
    char *colon = strrchr(name, ':');
    if (body == MBSR_NONE && colon) {
        *colon = '\0';
        body = contact_body(m, name);
        other = contact_body(m, colon + 1);
    }
    if (body == MBSR_NONE || other == MBSR_NONE)
        return complain(USAGE, "--output: there is no body '%s'",
                        body == MBSR_NONE ? name : colon + 1);
    return add_contact(body, other, given, c) ? DONE : complain(FAILED, "no memory");
}

static const char *sensor_unit(const mbsr_file *f, const mbsr_file_sensor *sensor)
{
    static const char *const units[] = {[MBSR_SENSOR_BALL] = "1",
                                        [MBSR_SENSOR_BALL_RATE] = "rad/s",
                                        [MBSR_SENSOR_POINT] = "m",
                                        [MBSR_SENSOR_AXIS_X] = "1",
                                        [MBSR_SENSOR_AXIS_Y] = "1",
                                        [MBSR_SENSOR_AXIS_Z] = "1",
                                        [MBSR_SENSOR_TURN] = "1",
                                        [MBSR_SENSOR_VELOCITY] = "m/s",
                                        [MBSR_SENSOR_SPIN] = "rad/s",
                                        [MBSR_SENSOR_ACCELERATION] = "m/s^2",
                                        [MBSR_SENSOR_SPIN_RATE] = "rad/s^2",
                                        [MBSR_SENSOR_FORCE] = "N",
                                        [MBSR_SENSOR_TORQUE] = "N m",
                                        [MBSR_SENSOR_CENTRE] = "m",
                                        [MBSR_SENSOR_CENTRE_VELOCITY] = "m/s",
                                        [MBSR_SENSOR_MOMENTUM] = "kg m^2/s",
                                        [MBSR_SENSOR_TIME] = "s",
                                        [MBSR_SENSOR_POTENTIAL] = "J",
                                        [MBSR_SENSOR_KINETIC] = "J"};
    const bool rate = sensor->kind == MBSR_SENSOR_RATE;
    if (sensor->kind == MBSR_SENSOR_POSITION || rate) {
        if (sensor->joint >= 0) return joint_unit(f->joint[sensor->joint].kind, 0, rate);
        return sensor->sites > 0 ? (rate ? "m/s" : "m") : "1";
    }
    return units[sensor->kind] ? units[sensor->kind] : "1";
}

/* By the name of the sensor. */
static bool add_sensor(const program_model *m, int k, columns *c)
{
    static const char *const parts = "wxyz";
    const mbsr_file_sensor *sensor = m->file->sensor + k;
    c->file = m->file;
    for (int l = 0; l < sensor->size; ++l) {
        column new = {
            .kind = COLUMN_SENSOR, .unit = sensor_unit(m->file, sensor), .at = k, .part = l};
        const char part[3] = {'.', parts[sensor->size == 4 ? l : l + 1], '\0'};
        snprintf(new.name, sizeof new.name, "%.150s%s", sensor->name, sensor->size > 1 ? part : "");
        if (!append_column(c, new)) return false;
    }
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
        good = add_joint_columns(m, false, c) && add_joint_columns(m, true, c);
    } else if (strcmp(name, "energy") == 0) {
        good =
            append_column(c, (column){.name = "kinetic", .unit = "J", .kind = COLUMN_KINETIC}) &&
            append_column(c, (column){.name = "potential", .unit = "J", .kind = COLUMN_POTENTIAL});
    } else if (joint >= 0) {
        good = add_joint_column(m, joint, false, c);
    } else if (mbsr_file_find_sensor(m->file, name) >= 0) {
        good = add_sensor(m, mbsr_file_find_sensor(m->file, name), c);
    } else if (ends_with(name, ".rate")) {
        joint = mbsr_file_find_joint(m->file, name);
        if (joint < 0) return complain(USAGE, "--output: there is no joint '%s'", name);
        good = add_joint_column(m, joint, true, c);
    } else if (strcmp(name, "contacts") == 0) {
        good = add_all_contacts(m, c);
    } else if (ends_with(name, ".contact")) {
        return add_named_contact(m, name, c);
    } else if (ends_with(name, ".pos")) {
        const int body = mbsr_model_find_body(m->model, name);
        if (body < 0) return complain(USAGE, "--output: there is no body '%s'", name);
        good = add_position(body, given, c);
    } else {
        return complain(USAGE, "--output: there is no joint '%s'", name);
    }
    return good ? DONE : complain(FAILED, "no memory");
}

int columns_all(const program_model *m, columns *c)
{
    *c = (columns){.file = m->file};
    bool good = add_joint_columns(m, false, c) && add_joint_columns(m, true, c) &&
                !add_name(m, "energy", c);
    for (int k = 0; k < m->file->sensors && good; ++k) good = add_sensor(m, k, c);
    for (int k = 0; k < mbsr_model_bodies(m->model) && good; ++k) {
        char name[200];
        const char *body = mbsr_body_name(m->model, k);
        snprintf(name, sizeof name, "%.150s.pos", body ? body : "");
        good = add_position(k, name, c);
    }
    return good ? DONE : complain(FAILED, "no memory");
}

int columns_make(const program_model *m, const char *names, columns *c)
{
    int code = DONE;
    *c = (columns){.list = NULL};
    if (!names && !add_joint_columns(m, false, c)) return complain(FAILED, "no memory");
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

bool columns_have_contacts(const columns *c)
{
    bool any = false;
    for (int k = 0; k < c->count; ++k) any = any || c->list[k].kind == COLUMN_CONTACT;
    return any;
}

static int value_of(const columns *c, const column *of, const mbsr_model *model, mbsr_data *data,
                    double t, const double *q, const double *u, double *value)
{
    double pose[MBSR_POSE_SIZE] = {0.0}, sensed[4], load[6], kinetic, potential;
    int status = MBSR_OK;
    switch (of->kind) {
    case COLUMN_Q: *value = q[of->at]; break;
    case COLUMN_U: *value = u[of->at]; break;
    case COLUMN_POSITION:
        status = mbsr_body_pose(model, data, of->at, pose);
        if (!status) *value = pose[MBSR_POSE_X + of->part];
        break;
    case COLUMN_SENSOR:
        status = mbsr_file_sense(c->file, of->at, model, data, t, q, u, sensed);
        if (!status) *value = sensed[of->part];
        break;
    case COLUMN_CONTACT:
        if (of->at != MBSR_GROUND) status = mbsr_body_pose(model, data, of->at, pose);
        touching_load(c->touching, of->at, of->other, pose + MBSR_POSE_X, load);
        *value = load[of->part];
        break;
    case COLUMN_KINETIC:
    case COLUMN_POTENTIAL:
        status = mbsr_energy(model, data, &kinetic, &potential);
        if (!status) *value = of->kind == COLUMN_KINETIC ? kinetic : potential;
        break;
    }
    return status;
}

int columns_values(const columns *c, const mbsr_model *model, mbsr_data *data, double t,
                   const double *q, const double *u, double *value)
{
    int status = MBSR_OK;
    if (columns_have_contacts(c) && touching_look(c->touching, data)) return FAILED;
    for (int k = 0; k < c->count && !status; ++k)
        status = value_of(c, c->list + k, model, data, t, q, u, value + k);
    return status;
}
