/* Sensors of MJCF that a state gives. Others are not looked at.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/solids.h"

#include <string.h>

static bool is(const char *a, const char *b)
{
    return a && strcmp(a, b) == 0;
}

/* jointpos and jointvel of joints with one axis. */
static bool find_joint(const mbsri_mjcf *m, const mbsri_element *e, mbsr_file_sensor *sensor)
{
    sensor->joint = mbsri_names_find(&m->joints, mbsri_attribute(e, "joint"));
    if (sensor->joint < 0) return false;
    const mbsr_file_joint_kind kind = mbsri_scene_joints(m->s)[sensor->joint].joint.kind;
    return kind == MBSR_FILE_HINGE || kind == MBSR_FILE_SLIDE;
}

/* framepos of a site, or of a body: its origin, or its centre of mass. */
static bool find_point(const mbsri_mjcf *m, const mbsri_element *e, mbsr_file_sensor *sensor)
{
    const char *type = mbsri_attribute(e, "objtype"), *name = mbsri_attribute(e, "objname");
    const bool site = is(type, "site"), body = is(type, "body") || is(type, "xbody");
    const int at = site   ? mbsri_names_find(&m->sites, name)
                   : body ? mbsri_names_find(&m->bodies, name)
                          : -1;
    double mass, tensor[6];
    if (at < 0 || mbsri_attribute(e, "refname")) return false;
    sensor->body = at;
    if (site) {
        const mbsr_file_site *s = (const mbsr_file_site *)m->s->sites.items + at;
        sensor->body = s->body;
        memcpy(sensor->point, s->frame.x, sizeof sensor->point);
    }
    return !is(type, "body") ||
           mbsri_solid_of(&mbsri_scene_bodies(m->s)[at].inertia, &mass, sensor->point, tensor);
}

bool mbsri_mjcf_sensors(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = list->child; e; e = e->next) {
        mbsr_file_sensor sensor = {.name = mbsri_mjcf_name(e), .joint = -1, .body = -1};
        const bool position = mbsri_is(e, "jointpos"), rate = mbsri_is(e, "jointvel"),
                   point = mbsri_is(e, "framepos");
        sensor.kind = position ? MBSR_SENSOR_POSITION : rate ? MBSR_SENSOR_RATE : MBSR_SENSOR_POINT;
        if (!(position || rate || point)) continue;
        if (!(point ? find_point : find_joint)(m, e, &sensor)) continue;
        mbsr_file_sensor *to = mbsri_list_add(m->s->arena, &m->s->sensors, sizeof *to);
        if (!to) return false;
        *to = sensor;
    }
    return true;
}
