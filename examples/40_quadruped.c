/* A robot on four legs stands, and trots by PD control; its feet have no mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The model is read from a file, without its actuators: servos that follow splines take their
 * place. In a trot the feet at opposite corners go together, half of the time on the floor, where
 * they move backwards, and half of it above. Angles of hip and knee follow from where the foot is
 * to be. Nothing is told of the floor: the shapes of the file touch. quadruped.csv has where the
 * trunk is and what each foot carries. */
#include "build.h"

#include <mbsrank/contact.h>
#include <mbsrank/files.h>
#include <mbsrank/simulation.h>

#include <math.h>
#include <string.h>

enum { LEGS = 4, POINTS = 57, MOST = 64 };
static const char *const leg_name[LEGS] = {"FL", "FR", "RL", "RR"};
static const double stand_still = 0.4, t_end = 2.8; /* s */

/* Where a foot is to be under its hip, x forward, z up. */
static void foot_at(double t, int leg, double foot[2])
{
    const double period = 0.4, reach = 0.045, lift = 0.05, pi = 3.14159265358979323846;
    const double grown = fmin(1.0, fmax(0.0, (t - stand_still) / 0.6));
    double phase = (t - stand_still) / period + (leg == 1 || leg == 2 ? 0.5 : 0.0);
    phase -= floor(phase);
    foot[0] = 0.0, foot[1] = -0.335;
    if (phase < 0.5) {
        foot[0] = grown * reach * (1.0 - 4.0 * phase);
    } else {
        foot[0] = -grown * reach * cos(pi * (2.0 * phase - 1.0));
        foot[1] += grown * lift * pow(sin(pi * (2.0 * phase - 1.0)), 2.0);
    }
}

/* Hip and knee for a foot there; both bones are 0.2 m long. */
static void reach_foot(const double foot[2], double *hip, double *knee)
{
    const double bone = 0.2, square = foot[0] * foot[0] + foot[1] * foot[1];
    *knee = -acos(square / (2.0 * bone * bone) - 1.0);
    *hip = atan2(-foot[0], -foot[1]) - 0.5 * *knee;
}

static void *read_whole(const char *path, size_t *size)
{
    FILE *from = fopen(path, "rb");
    char *text = malloc(1 << 16);
    *size = from && text ? fread(text, 1, 1 << 16, from) : 0;
    if (from) fclose(from);
    return text;
}

static mbsr_file *read_robot(const char *path)
{
    size_t size;
    mbsr_file *file;
    mbsr_error error;
    mbsr_file_opt opt = mbsr_default_file_opt();
    char *text = read_whole(path, &size);
    opt.actuators = 0;
    check(mbsr_file_read(text, size, path, &opt, &file, &error), &error);
    free(text);
    check(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    return file;
}

/* The file's model with the element of all shapes; *force is its id. */
static mbsr_model *touching_model(const mbsr_file *file, mbsr_contacts **contacts, int *force)
{
    mbsr_error error;
    mbsr_force_def element;
    mbsr_model *model;
    check(mbsr_contacts_create(contacts, &error), &error);
    check(mbsr_contacts_add_file(*contacts, file, file->model, 0.0, NULL, &error), &error);
    check(mbsr_contacts_force(*contacts, 0, &element, &error), &error);
    check(mbsr_model_copy(file->model, &model, &error), &error);
    check(mbsr_model_add_force(model, &element, force), mbsr_model_error(model));
    return model;
}

/* Servos on hips and knees, which are at the start where they are to be. */
static void add_servos(mbsr_simulation *s, const mbsr_file *file, double *q)
{
    double x[POINTS], angle[2][POINTS];
    for (int leg = 0; leg < LEGS; ++leg) {
        for (int k = 0; k < POINTS; ++k) {
            double foot[2];
            x[k] = t_end * k / (POINTS - 1);
            foot_at(x[k], leg, foot);
            reach_foot(foot, &angle[0][k], &angle[1][k]);
        }
        for (int k = 0; k < 2; ++k) {
            char name[16];
            int at;
            snprintf(name, sizeof name, "%s %s", leg_name[leg], k ? "knee" : "hip");
            const int body = file->joint[mbsr_file_find_joint(file, name)].body;
            const mbsr_servo servo = {
                .kp = 300.0,
                .kd = 8.0,
                .limit = 60.0,
                .table = mbsr_simulation_add_table(s, MBSR_TABLE_SPLINE, POINTS, x, angle[k])};
            mbsr_simulation_add_force(s, mbsr_force_joint_servo(body, 0, &servo));
            check(mbsr_body_coordinates(file->model, body, &at, NULL, NULL, NULL), NULL);
            q[at] = angle[k][0];
        }
    }
}

/* A line of the file: t, x, z and pitch of the trunk, what each foot carries, N. */
static void write_line(FILE *to, const mbsr_simulation *s, int force, const int foot[LEGS])
{
    mbsr_contact_point point[MOST];
    double load[LEGS] = {0.0};
    int count;
    check(mbsr_contact_report(s->model, s->data, force, MOST, point, &count),
          mbsr_data_error(s->data));
    for (int k = 0; k < count && k < MOST; ++k) {
        for (int leg = 0; leg < LEGS; ++leg)
            if (point[k].body_b == foot[leg]) load[leg] += point[k].normal_force;
    }
    fprintf(to, "%.4f,%.6f,%.6f,%.6f", s->t, s->q[4], s->q[6], 2.0 * asin(s->q[2]));
    for (int leg = 0; leg < LEGS; ++leg) fprintf(to, ",%.3f", load[leg]);
    fputc('\n', to);
}

int main(int argc, char **argv)
{
    mbsr_file *file = read_robot(argc > 1 ? argv[1] : "quadruped.xml");
    mbsr_contacts *contacts;
    int force, foot[LEGS];
    double *q = malloc((size_t)file->nq * sizeof *q), lowest = 1.0, highest = 0.0, before = 0.0;
    mbsr_simulation s = mbsr_simulation_of(touching_model(file, &contacts, &force));
    memcpy(q, file->q0, (size_t)file->nq * sizeof *q);
    add_servos(&s, file, q);
    for (int leg = 0; leg < LEGS; ++leg) {
        char name[16];
        snprintf(name, sizeof name, "%s foot", leg_name[leg]);
        foot[leg] = mbsr_model_find_body(file->model, name);
    }

    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-4;
    mbsr_simulation_start(&s, &opt, 0.0, q, NULL);
    FILE *to = csv("quadruped.csv");
    for (int n = 0; n <= 280 && !s.status && !mbsr_simulation_to(&s, t_end * n / 280); ++n) {
        write_line(to, &s, force, foot);
        if (s.t <= 2.0) before = s.q[4];
        lowest = fmin(lowest, s.q[6]);
        highest = fmax(highest, s.q[6]);
    }
    fclose(to);
    check(s.status, &s.error);
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    const double speed = (s.q[4] - before) / 0.8;
    printf("%.2f m/s, the trunk is %.3f to %.3f m high, %ld steps for %.1f s\n", speed, lowest,
           highest, stats.steps, t_end);
    mbsr_simulation_end(&s);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
    free(q);
    return speed > 0.2 && lowest > 0.3 && highest < 0.4 ? 0 : 1;
}
