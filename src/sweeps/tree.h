/* The tree that the vectorised sweeps run over: rigid bodies with stock joints, in space or
 * embedded there (embed.h). SPDX-License-Identifier: BSD-3-Clause
 *
 * The recursion is that of recursion/backward.c and recursion/forward.c, with what a rigid body and
 * a joint of one axis make of it (docs/performance.md): all vectors along the world's axes about a
 * point of the joint's axis, so that H is a translation; the axis is the z axis of a frame chosen
 * when the model is finished; Mbar is three blocks of 3 x 3, kept in registers from a body to its
 * predecessor. */
#ifndef MBSRI_TREE_H
#define MBSRI_TREE_H

#include "recursion/data.h"
#include "recursion/rank_rule.h"
#include "sweeps/embed.h"

/* Returned where the sweeps do not serve. */
enum { MBSRI_NOT_SERVED = 1 << 20 };

/* What a body is; bits of mbsri_sweep_body.flags, of which batch/record.h has some more. */
enum {
    MBSRI_TURNS = 1,        /* its joint rotates about z */
    MBSRI_SLIDES = 2,       /* and moves along z, by `pitch` per unit of the coordinate */
    MBSRI_MULTI = 4,        /* its joint is none of one axis: see multi_axis.h */
    MBSRI_MASSLESS = 8,     /* own inertia zero */
    MBSRI_LEAF = 16,        /* no successor */
    MBSRI_BRANCHES = 32,    /* more than one successor */
    MBSRI_NEXT = 64,        /* its predecessor is the body before, or the root */
    MBSRI_OPENS = 128,      /* the first of several successors that the backward sweep meets */
    MBSRI_LOADED = 256,     /* force elements act on the body */
    MBSRI_FRONT = 1024,     /* loops are open past its joint; see loops.h and newton/ */
    MBSRI_CLOSES = 2048,    /* and close on it */
    MBSRI_STIFFENED = 4096, /* not of bodies: what these add to inertia is there */
    MBSRI_PLANE = 512,      /* it lies in the plane */
    MBSRI_FLAT = 524288,    /* and so do all bodies behind it */
    MBSRI_LEVEL = 1048576,  /* and all before it */
    MBSRI_BLOCK = 8192,     /* it is of another kind: see block.h, and the next two */
    MBSRI_TO_BLOCK = 16384, /* its predecessor is */
    MBSRI_BOUNDED = 65536,  /* a block that is not in GENERAL space, nor is its predecessor */
    MBSRI_SIX = 131072,     /* its predecessor is in space, and no block */
    MBSRI_FREE = 536870912, /* MULTI, six rates along the axes of a root at rest: S = 1 */
    MBSRI_USERS = 2097152,  /* MULTI, moved by a user's functions: see users_joint.h */
    MBSRI_SHARP = 32768,    /* a block that has none but blocks behind it, so that its W is exact */
    MBSRI_ACTED = 134217728, /* LOADED by elements, not by closures alone */
    MBSRI_PLACED = 33554432, /* somebody looks where it is, or where one behind it is */
    /* in Newton systems with loops, see newton/sweeps/looped.h */
    MBSRI_ACTING =
        268435456,         /* it is ACTED, or one behind it, or by closures that do not balance */
    MBSRI_HEAVY = 4194304, /* it has inertia, or one behind it, or a joint of these */
    MBSRI_WIDE = 8388608,  /* all 12 columns count at it */
    MBSRI_WIDE_JOINT = 16777216, /* and in its predecessor's, which is WIDE */
    MBSRI_TO_WIDE = 67108864     /* its predecessor is WIDE */
};

/* Constants of a body. Its frame has its origin on the joint's axis and z along it; matrices by
 * columns of four. */
typedef struct mbsri_sweep_body {
    double A[12];  /* axes of the frame at q = 0 in the predecessor's frame */
    double x[4];   /* its origin there, m */
    double I[12];  /* inertia tensor about the frame's origin */
    double c[4];   /* first moment, kg m; mass, kg */
    double pitch;  /* m per unit of the coordinate; 1 for a slider */
    double soft;   /* 1 / lambda with M >= lambda Lambda; 0: M is not regular */
    double spread; /* (1 + |x| / L)^2 */
    int parent, flags;
    int q, u;  /* places of its coordinates in the order of the sweeps */
    int multi; /* number among the MBSRI_MULTI bodies */
    int n;
    double armature; /* along its coordinate; of several axes see the model's */
    double mixes;    /* 1 with armature, else 0: see rank_bound.h */
} mbsri_sweep_body;

/* The sweeps load four numbers at once, from places that are multiples of 32 bytes. */
#define MBSRI_CHECK_LAYOUT(type) _Static_assert(sizeof(type) % 32 == 0, #type)
MBSRI_CHECK_LAYOUT(mbsri_sweep_body);

/* A joint of other than one axis, or with a prescribed one: its body's frame is the body's own. */
typedef struct mbsri_sweep_joint {
    double R[9], x[3]; /* the predecessor's own frame in the frame that these sweeps use of it */
    mbsri_joint chain; /* as a chain of steps */
    double param[MBSRI_EMBED_PARAMS];
} mbsri_sweep_joint;

/* The body's own frame in that of the sweeps; for a PLANAR body its angle, which is that of its
 * predecessor plus `angle` and a coordinate of its joint (mbsri_embedded_angle). */
typedef struct mbsri_sweep_own {
    double R[9], x[3], angle;
    int coordinate;
} mbsri_sweep_own;

/* And its state, kept by multi_axis.h. */
typedef struct mbsri_sweep_multi {
    double S[6][8];    /* columns of V = S u: angular and linear part, four numbers each */
    double U[6][8];    /* Mbar S */
    double G[6][8];    /* Mbar S D^-1 */
    double Sdot[6][8]; /* rates of S, for the momentum form */
    double drive[8];   /* part of V - X V_pi that does not depend on u */
    double driven[8];  /* Mbar times that */
    double D[6][6];
    double factor[6][6]; /* of D */
    double x[6];         /* e, D^-1 e or ep */
    double e[6];         /* of a joint without inertia: e */
} mbsri_sweep_multi;
MBSRI_CHECK_LAYOUT(mbsri_sweep_multi);

/* s times columns of six numbers, as two vectors of four each. */
static inline void mbsri_spread_out(int n, double s, const double *from, double (*to)[8])
{
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < 3; ++l) {
            to[k][l] = s * from[6 * k + l];
            to[k][4 + l] = s * from[6 * k + 3 + l];
        }
        to[k][3] = to[k][7] = 0.0;
    }
}

/* State of a body in one evaluation; vectors of four numbers. */
typedef struct mbsri_sweep_state {
    double R[12];          /* axes of its frame in the world */
    double rho[4];         /* from the predecessor's origin to its own, m */
    double omega[4];       /* angular velocity */
    double v[4];           /* velocity of its origin; momentum form only */
    double U_L[4], U_p[4]; /* Mbar S: angular and linear part */
    double A_w[4], A_v[4]; /* acceleration: first its part c without u', then all of it */
    double D, Dinv, e, ep; /* of a joint of one axis */
} mbsri_sweep_state;
MBSRI_CHECK_LAYOUT(mbsri_sweep_state);

/* Mbar, p and a bound of rounding errors (rank_bound.h) on the way to the predecessor. With V =
 * (omega, v):
 *
 *   Mbar = [I G^T; G M],   force = Mbar A + (L, p),   W <= kappa Mbar + spread Lambda
 *
 * with matrices by their diagonals (lane.h). */
typedef struct mbsri_carry {
    double I[8], G[12], M[8], L[4], p[4];
    double kappa, spread;
    double idle[2];
} mbsri_carry;
MBSRI_CHECK_LAYOUT(mbsri_carry);

/* A += Mbar, 6 x 6. */
static inline void mbsri_carry_add_to(const mbsri_carry *c, double A[36])
{
    for (int x = 0; x < 3; ++x) {
        const int y = (x + 1) % 3, z = (x + 2) % 3;
        const double row[3] = {c->G[x], c->G[4 + x], c->G[8 + x]};
        const int at[3] = {x, y, z};
        A[7 * x] += c->I[x];
        A[7 * (3 + x)] += c->M[x];
        A[6 * y + z] += c->I[4 + x], A[6 * z + y] += c->I[4 + x];
        A[6 * (3 + y) + 3 + z] += c->M[4 + x], A[6 * (3 + z) + 3 + y] += c->M[4 + x];
        for (int k = 0; k < 3; ++k) {
            A[6 * at[k] + 3 + x] += row[k];
            A[6 * (3 + x) + at[k]] += row[k];
        }
    }
}

/* Mbar of such a matrix. */
static inline void mbsri_carry_from(const double A[36], mbsri_carry *c)
{
    for (int x = 0; x < 3; ++x) {
        const int y = (x + 1) % 3, z = (x + 2) % 3;
        c->I[x] = A[7 * x];
        c->I[4 + x] = 0.5 * (A[6 * y + z] + A[6 * z + y]);
        c->G[x] = A[6 * x + 3 + x];
        c->G[4 + x] = A[6 * y + 3 + x];
        c->G[8 + x] = A[6 * z + 3 + x];
        c->M[x] = A[7 * (3 + x)];
        c->M[4 + x] = 0.5 * (A[6 * (3 + y) + 3 + z] + A[6 * (3 + z) + 3 + y]);
    }
    for (int k = 3; k < 8; k += 4) c->I[k] = c->M[k] = 0.0;
    for (int k = 3; k < 12; k += 4) c->G[k] = 0.0;
}

/* What the momentum form hands from a body to its predecessor: momentum (L, p) of all bodies from
 * here to the leaves, wrench (N, F) of the weights on them, and what of the given momenta is not
 * accounted for yet, (L_bar, p_bar), the recursion (17) with p for tau. */
typedef struct mbsri_flow {
    double L[4], p[4], N[4], F[4], L_bar[4], p_bar[4];
} mbsri_flow;
MBSRI_CHECK_LAYOUT(mbsri_flow);

typedef struct mbsri_sweep_loops mbsri_sweep_loops;

/* The tree, part of a finished model. */
typedef struct mbsri_sweeps {
    int bodies;               /* as the model's */
    mbsri_sweep_body *body;   /* bodies + 1, the root first */
    void *block;              /* where they were allocated */
    int multi;                /* number of MBSRI_MULTI bodies */
    mbsri_sweep_joint *joint; /* multi */
    int blocks;               /* number of MBSRI_BLOCK bodies */
    int *block_of;            /* blocks: which they are */
    bool rates;               /* all of them know their rates */
    int users;                /* number of MBSRI_USERS bodies */
    bool whole;               /* some are whole: W decides, not its bound */
    bool modal; /* W decides as well: behind some flexible body its bound seldom tells */
    bool open;  /* of Newton systems with loops, some of them blocks */
    bool light; /* such a one where bodies without inertia on loops are none */
    int depth;  /* predecessors waiting for further successors at once, at most */
    int first_angle, angles; /* the coordinates among which all angles are */
    double length;           /* L, m */
    double area, per_area;   /* L^2 and its inverse */
    /* weights of diagonals of I and M in the trace of Mbar by Lambda: in space, and LEVEL */
    double trace[2][8];
    mbsri_rank_rule rule;
    double gravity[4];        /* m/s^2, sum of all such elements, and 0 */
    bool joint_forces;        /* there are elements that act on joints alone */
    bool body_forces;         /* there are others, blocks or users' joints, which need as much */
    bool masses;              /* some of them read the mass matrices of their bodies */
    mbsri_sweep_own *own;     /* bodies + 1; body_forces only */
    int *loaded, loads;       /* likewise: LOADED bodies that are no blocks */
    mbsri_sweep_loops *loops; /* of the tree that is evaluated, or NULL */
    const struct mbsri_sweep_kernels *kernels;
} mbsri_sweeps;

/* What force elements exert on a body, about the origin of its frame; body_forces only. */
typedef struct mbsri_sweep_load {
    double r[4];   /* that origin in the world, m; the angle of a PLANAR body */
    double arm[4]; /* from there to the origin of the body's own frame */
    union {
        double L[4];     /* moment */
        double bound[4]; /* of a block: kappa and spread, see block_bound.h */
    };
    double p[4];
} mbsri_sweep_load;

/* What an evaluation works on. */
typedef struct mbsri_sweep_run {
    const mbsr_model *model;
    mbsr_data *data;
    const mbsri_sweeps *tree;
    mbsri_sweep_state *state; /* bodies + 1 */
    mbsri_sweep_multi *multi;
    mbsri_carry *stack;     /* depth */
    mbsri_carry *noise;     /* depth: W */
    mbsri_flow *flows;      /* depth */
    mbsri_sweep_load *load; /* bodies + 1, or NULL */
    double *sincos;         /* 2 a coordinate: cosine, sine */
    const double *q, *u;
    const double *tau;        /* joint forces; for inverse dynamics u' */
    double *out;              /* u', joint forces, or p' */
    const double *p;          /* momenta; momentum form only */
    double *balance;          /* its algebraic equations */
    int *rank;                /* bodies + 1, or NULL */
    const double *eta;        /* of position rows: C^T eta is left for mbsri_sweeps_push; or NULL */
    bool springs;             /* loop forces are those of springs alone */
    double *bias;             /* then: of rows of closures, asked for; or NULL */
    struct mbsr_split *split; /* parts of the tree for several threads, or NULL */
} mbsri_sweep_run;

struct mbsri_loop_run;

/* The sweeps, compiled once for every kind of processor. */
typedef struct mbsri_sweep_kernels {
    const char *name;
    void (*trigonometry)(int n, const double *q, double *sincos);
    int (*kinematics)(const mbsri_sweep_run *run);
    /* False: the stages have to decide on the rank of some joint. */
    bool (*backward)(const mbsri_sweep_run *run);
    void (*forward)(const mbsri_sweep_run *run);
    int (*inverse)(const mbsri_sweep_run *run);
    /* Kinematics with velocities; and, after backward, p' and the algebraic equations; a status. */
    int (*velocities)(const mbsri_sweep_run *run);
    int (*momentum)(const mbsri_sweep_run *run);
    /* One block, for states side by side: its step backward, with the bound of rounding errors,
     * where what a predecessor in the sweeps gets goes to c, and false stands for what it does
     * above; its step forward. */
    bool (*block_backward)(const mbsri_sweep_run *run, int i, mbsri_carry *c);
    void (*block_forward)(const mbsri_sweep_run *run, int i);
    const struct mbsri_part_kernels *parts; /* see split.h */
    /* backward and forward with loops, see loops.h. */
    bool (*loops_backward)(struct mbsri_loop_run *run);
    void (*loops_forward)(struct mbsri_loop_run *run);
    /* what loops take of the joint forces in `out`, see inverse_loops.h; false: the sweeps do not
     * serve */
    bool (*loops_inverse)(struct mbsri_loop_run *run);
    /* backward and momentum of large trees without blocks and users' joints; false: a rank is not
     * clear */
    bool (*momenta)(const mbsri_sweep_run *run);
} mbsri_sweep_kernels;

extern const mbsri_sweep_kernels mbsri_sweeps_base;
#if defined(MBSR_WITH_V3)
extern const mbsri_sweep_kernels mbsri_sweeps_v3;
#endif

#endif
