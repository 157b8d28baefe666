/* Sensors of MJCF that a state gives; others are findings.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/solids.h"

#include <string.h>

/* What a sensor is on. */
typedef enum object {
    ON_AXIS,     /* a joint with one axis */
    ON_BALL,     /* a ball joint */
    ON_TENDON,   /* one of the model */
    ON_ACTUATOR, /* likewise */
    ON_FRAME,    /* what objtype says, as seen from reftype */
    ON_SITE,     /* along its axes */
    ON_BODY,
    ON_NOTHING
} object;

typedef struct sensor_type {
    const char *name;
    object on;
    mbsr_file_sensor_kind kind;
    int size;
} sensor_type;

static const sensor_type types[] = {
    {"jointpos", ON_AXIS, MBSR_SENSOR_POSITION, 1},
    {"jointvel", ON_AXIS, MBSR_SENSOR_RATE, 1},
    {"jointactuatorfrc", ON_AXIS, MBSR_SENSOR_JOINT_DRIVE, 1},
    {"ballquat", ON_BALL, MBSR_SENSOR_BALL, 4},
    {"ballangvel", ON_BALL, MBSR_SENSOR_BALL_RATE, 3},
    {"tendonpos", ON_TENDON, MBSR_SENSOR_POSITION, 1},
    {"tendonvel", ON_TENDON, MBSR_SENSOR_RATE, 1},
    {"actuatorpos", ON_ACTUATOR, MBSR_SENSOR_POSITION, 1},
    {"actuatorvel", ON_ACTUATOR, MBSR_SENSOR_RATE, 1},
    {"actuatorfrc", ON_ACTUATOR, MBSR_SENSOR_DRIVE, 1},
    {"framepos", ON_FRAME, MBSR_SENSOR_POINT, 3},
    {"framequat", ON_FRAME, MBSR_SENSOR_TURN, 4},
    {"framexaxis", ON_FRAME, MBSR_SENSOR_AXIS_X, 3},
    {"frameyaxis", ON_FRAME, MBSR_SENSOR_AXIS_Y, 3},
    {"framezaxis", ON_FRAME, MBSR_SENSOR_AXIS_Z, 3},
    {"framelinvel", ON_FRAME, MBSR_SENSOR_VELOCITY, 3},
    {"frameangvel", ON_FRAME, MBSR_SENSOR_SPIN, 3},
    {"framelinacc", ON_FRAME, MBSR_SENSOR_ACCELERATION, 3},
    {"frameangacc", ON_FRAME, MBSR_SENSOR_SPIN_RATE, 3},
    {"accelerometer", ON_SITE, MBSR_SENSOR_ACCELERATION, 3},
    {"velocimeter", ON_SITE, MBSR_SENSOR_VELOCITY, 3},
    {"gyro", ON_SITE, MBSR_SENSOR_SPIN, 3},
    {"force", ON_SITE, MBSR_SENSOR_FORCE, 3},
    {"torque", ON_SITE, MBSR_SENSOR_TORQUE, 3},
    {"subtreecom", ON_BODY, MBSR_SENSOR_CENTRE, 3},
    {"subtreelinvel", ON_BODY, MBSR_SENSOR_CENTRE_VELOCITY, 3},
    {"subtreeangmom", ON_BODY, MBSR_SENSOR_MOMENTUM, 3},
    {"clock", ON_NOTHING, MBSR_SENSOR_TIME, 1},
    {"e_potential", ON_NOTHING, MBSR_SENSOR_POTENTIAL, 1},
    {"e_kinetic", ON_NOTHING, MBSR_SENSOR_KINETIC, 1},
};

static bool is(const char *a, const char *b)
{
    return a && strcmp(a, b) == 0;
}

/* ---- what it is on; false: it is left out ---- */

static mbsr_file_sum sum_of(const mbsri_scene_sum *sum)
{
    return (mbsr_file_sum){sum->count, sum->joint, sum->factor};
}

static bool sensed_joint(mbsri_mjcf *m, const mbsri_element *e, object on, mbsr_file_sensor *sensor)
{
    static const double one = 1.0;
    sensor->joint = mbsri_names_find(&m->joints, mbsri_attribute(e, "joint"));
    if (sensor->joint < 0) return false;
    const mbsr_file_joint_kind kind = mbsri_scene_joints(m->s)[sensor->joint].joint.kind;
    if (on == ON_BALL) return kind == MBSR_FILE_BALL;
    int *number = mbsri_arena_take(m->s->arena, sizeof *number);
    if (!number) return false;
    *number = sensor->joint;
    sensor->sum = (mbsr_file_sum){1, number, &one};
    return kind == MBSR_FILE_HINGE || kind == MBSR_FILE_SLIDE;
}

static bool find_tendon(const mbsri_mjcf *m, const mbsri_element *e, mbsr_file_sensor *sensor)
{
    const mbsri_scene_tendon *t = m->s->tendons.items;
    for (int k = 0; k < m->s->tendons.count; ++k) {
        if (!is(mbsri_attribute(e, "tendon"), t[k].name)) continue;
        sensor->sum = sum_of(&t[k].sum);
        sensor->sites = t[k].count;
        sensor->site = t[k].site;
        return t[k].count > 0 || t[k].sum.count > 0;
    }
    return false;
}

static bool find_actuator(const mbsri_mjcf *m, const mbsri_element *e, mbsr_file_sensor *sensor)
{
    const mbsri_scene_actuator *a = m->s->actuators.items;
    for (int k = 0; k < m->s->actuators.count; ++k) {
        if (!is(mbsri_attribute(e, "actuator"), a[k].actuator.name)) continue;
        sensor->actuator = k;
        sensor->sum = sum_of(&a[k].sum);
        return a[k].sum.count > 0 || (a[k].site >= 0 && sensor->kind == MBSR_SENSOR_DRIVE);
    }
    return false;
}

/* The frame that a name of that type means: of a site, a body or its centre of mass, a geom that is
 * no mesh. */
static bool sensed_frame(const mbsri_mjcf *m, const char *type, const char *name, bool turned,
                         int *body, mbsr_frame *frame)
{
    const mbsr_file_shape *shape = m->s->shapes.items;
    const mbsri_names *names = is(type, "site") ? &m->sites : &m->bodies;
    double mass, tensor[6];
    *frame = mbsr_frame_identity();
    if (is(type, "geom")) {
        for (int k = 0; k < m->s->shapes.count; ++k) {
            if (!is(name, shape[k].name) || shape[k].kind == MBSR_SHAPE_MESH) continue;
            *body = shape[k].body;
            *frame = shape[k].frame;
            return true;
        }
        return false;
    }
    const int at = mbsri_names_find(names, name);
    *body = at;
    if (is(type, "xbody") && is(name, "world")) return true;
    if (at < 0) return false;
    if (is(type, "xbody")) return true;
    if (is(type, "body"))
        return !turned &&
               mbsri_solid_of(&mbsri_scene_bodies(m->s)[at].inertia, &mass, frame->x, tensor);
    const mbsr_file_site *site = (const mbsr_file_site *)m->s->sites.items + at;
    *body = site->body;
    *frame = site->frame;
    return is(type, "site");
}

/* Where what is asked for depends on the axes of the frame itself. */
static bool is_turned(mbsr_file_sensor_kind kind)
{
    return kind == MBSR_SENSOR_TURN || (kind >= MBSR_SENSOR_AXIS_X && kind <= MBSR_SENSOR_AXIS_Z);
}

static bool find_frames(const mbsri_mjcf *m, const mbsri_element *e, mbsr_file_sensor *sensor)
{
    const char *reference = mbsri_attribute(e, "refname");
    sensor->relative = reference != NULL;
    return sensed_frame(m, mbsri_attribute(e, "objtype"), mbsri_attribute(e, "objname"),
                        is_turned(sensor->kind), &sensor->body, &sensor->frame) &&
           (!reference || sensed_frame(m, mbsri_attribute(e, "reftype"), reference, true,
                                       &sensor->from_body, &sensor->from));
}

static bool find_object(mbsri_mjcf *m, const mbsri_element *e, object on, mbsr_file_sensor *sensor)
{
    const char *body = mbsri_attribute(e, "body");
    switch (on) {
    case ON_AXIS:
    case ON_BALL: return sensed_joint(m, e, on, sensor);
    case ON_TENDON: return find_tendon(m, e, sensor);
    case ON_ACTUATOR: return find_actuator(m, e, sensor);
    case ON_FRAME: return find_frames(m, e, sensor);
    case ON_SITE:
        sensor->own_axes = 1;
        return sensed_frame(m, "site", mbsri_attribute(e, "site"), true, &sensor->body,
                            &sensor->frame) &&
               (sensor->body >= 0 ||
                (sensor->kind != MBSR_SENSOR_FORCE && sensor->kind != MBSR_SENSOR_TORQUE));
    case ON_BODY:
        sensor->body = mbsri_names_find(&m->bodies, body);
        return sensor->body >= 0 || is(body, "world");
    case ON_NOTHING: break;
    }
    return true;
}

/* ---- sensors ---- */

static bool add_sensor(mbsri_mjcf *m, const mbsri_element *e)
{
    const sensor_type *type = NULL;
    for (size_t k = 0; k < sizeof types / sizeof *types && !type; ++k)
        if (mbsri_is(e, types[k].name)) type = types + k;
    if (!type) {
        mbsri_file_find(m->s, e, "it is left out: no state gives what it senses");
        return true;
    }
    mbsr_file_sensor sensor = {.name = mbsri_mjcf_name(e),
                               .kind = type->kind,
                               .size = type->size,
                               .joint = -1,
                               .actuator = -1,
                               .body = -1,
                               .frame = mbsr_frame_identity(),
                               .from_body = -1,
                               .from = mbsr_frame_identity()};
    memcpy(sensor.gravity, m->s->gravity, sizeof sensor.gravity);
    if (!mbsri_numbers(m->s, e, "cutoff", mbsri_attribute(e, "cutoff"), 1, 1, &sensor.cutoff, NULL))
        return false;
    if (mbsri_attribute(e, "delay") || mbsri_attribute(e, "interval"))
        mbsri_file_find(m->s, e, "it gives its numbers at once");
    if (!find_object(m, e, type->on, &sensor)) {
        mbsri_file_find(m->s, e, "it is left out: what it is on is none that the model has");
        return true;
    }
    mbsr_file_sensor *to = mbsri_list_add(m->s->arena, &m->s->sensors, sizeof *to);
    if (to) *to = sensor;
    return to != NULL;
}

bool mbsri_mjcf_sensors(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = list->child; e; e = e->next) {
        if (!add_sensor(m, e)) return false;
    }
    return true;
}
