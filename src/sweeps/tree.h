/* The tree that the vectorised sweeps run over: rigid bodies with stock joints, in space or
 * embedded there (embed.h).
 * SPDX-License-Identifier: BSD-3-Clause
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

/* Properties of a body; bits of mbsri_sweep_body.flags, of which batch/record.h has some more. */
enum {
    /* the joint */
    MBSRI_TURNS = 1,        /* one axis: the joint rotates about z */
    MBSRI_SLIDES = 2,       /* one axis: it moves along z, by `pitch` per unit of the coordinate */
    MBSRI_MULTI = 4,        /* the joint has other than one axis: multi_axis.h */
    MBSRI_FREE = 536870912, /* MULTI with six rates along the axes of a root at rest: S = 1 */
    MBSRI_USERS = 2097152,  /* MULTI moved by a user's functions: users_joint.h */
    /* inertia and what acts */
    MBSRI_MASSLESS = 8,      /* the body's own inertia is zero */
    MBSRI_LOADED = 256,      /* force elements or closures act on the body */
    MBSRI_ACTED = 134217728, /* force elements act on it */
    MBSRI_STIFFENED = 4096,  /* not of bodies: what elements add to the inertia is there */
    MBSRI_PLACED = 33554432, /* something asks for the place of the body, or of one behind it */
    /* the tree */
    MBSRI_LEAF = 16,     /* the body has no successor */
    MBSRI_BRANCHES = 32, /* it has more than one */
    MBSRI_NEXT = 64,     /* its predecessor is the body before it, or the root */
    MBSRI_OPENS = 128,   /* it is the first of several successors that the backward sweep meets */
    /* the plane */
    MBSRI_PLANE = 512,     /* the body lies in the plane */
    MBSRI_FLAT = 524288,   /* it does, and so do all bodies behind it */
    MBSRI_LEVEL = 1048576, /* it does, and so do all bodies before it */
    /* bodies of other kinds: block.h */
    MBSRI_BLOCK = 8192,     /* the body is a block */
    MBSRI_TO_BLOCK = 16384, /* its predecessor is one */
    MBSRI_BOUNDED = 65536,  /* it is one, and neither it nor its predecessor is in GENERAL space */
    MBSRI_SIX = 131072,     /* it is one, and its predecessor is in space and none */
    MBSRI_SHARP = 32768,    /* it is one, and behind it are only such: its W is exact */
    /* loops: loops.h, newton/sweeps/looped.h */
    MBSRI_FRONT = 1024,          /* a loop spans the joint */
    MBSRI_CLOSES = 2048,         /* a loop closes on the body */
    MBSRI_ACTING = 268435456,    /* ACTED, it or one behind it, or by closures without balance */
    MBSRI_HEAVY = 4194304,       /* inertia, its own or behind it, or along a joint of these */
    MBSRI_WIDE = 8388608,        /* 12 columns in Newton systems */
    MBSRI_WIDE_JOINT = 16777216, /* 12 columns, and as many of its predecessor */
    MBSRI_TO_WIDE = 67108864     /* its predecessor has 12 columns */
};

/* Constants of a body. Its frame has its origin on the joint's axis and z along it; matrices by
 * columns of four. */
typedef struct mbsri_sweep_body {
    double A[12];      /* axes of the frame at q = 0 in the predecessor's frame */
    double x[4];       /* its origin there, m */
    double I[12];      /* inertia tensor about the frame's origin */
    double c[4];       /* first moment, kg m; mass, kg */
    double pitch;      /* m per unit of the coordinate; 1 for a slider */
    double soft;       /* 1 / lambda with M >= lambda Lambda; 0: M is not regular */
    double spread;     /* (1 + |x| / L)^2 */
    int parent, flags; /* index of the predecessor; the bits above */
    int q, u;          /* index of its first coordinate and rate in the order of the sweeps */
    int multi;         /* index among the MBSRI_MULTI bodies */
    int n;             /* joint rates */
    double armature;   /* armature of a joint of one axis, kg m^2 or kg */
    double mixes;      /* 1 with armature, else 0: see rank_bound.h */
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
    double factor[6][6]; /* factors of D */
    double x[6];         /* e, D^-1 e or ep */
    double e[6];         /* e of a joint without inertia */
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

/* x <- D^-1 x, by the factors of D */
static inline void mbsri_solve_joint(int n, double D[6][6], double x[6])
{
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < k; ++l) x[k] -= D[k][l] * x[l];
    }
    for (int k = 0; k < n; ++k) x[k] *= D[k][k];
    for (int k = n - 1; k >= 0; --k) {
        for (int l = k + 1; l < n; ++l) x[k] -= D[l][k] * x[l];
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
    double D, Dinv, e, ep; /* D, D^-1, e and ep of a joint of one axis */
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
    bool rates; /* whether rates of K, H, J of all blocks are known, not differenced */
    int users;  /* number of MBSRI_USERS bodies */
    bool whole; /* whether some blocks are `whole` bodies: then W decides on ranks, not its bound */
    bool modal; /* whether flexible bodies are among them: then W decides too */
    bool with_loops;         /* whether the tree is that of Newton systems with loops */
    bool massless_on_loop;   /* whether it is, and bodies massless on a loop are no blocks */
    int depth;               /* most predecessors that wait for further successors at once */
    int first_angle, angles; /* first coordinate, and number, of those among which all angles are */
    double length;           /* L, m */
    double area, per_area;   /* L^2 and its inverse */
    /* weights of diagonals of I and M in the trace of Mbar by Lambda: in space, and LEVEL */
    double trace[2][8];
    mbsri_rank_rule rule;
    double gravity[4];    /* sum of all gravity elements, m/s^2; and 0 */
    bool joint_forces;    /* whether elements act on joints alone */
    bool body_forces;     /* whether elements act on bodies, or blocks or users' joints are there */
    bool masses;          /* whether elements read the mass matrices of their bodies */
    mbsri_sweep_own *own; /* bodies + 1: the body's own frames; NULL without body_forces */
    int *loaded, loads;   /* LOADED bodies that are no blocks, and their number, likewise */
    mbsri_sweep_loops *loops; /* loops of the tree of evaluations, or NULL */
    const struct mbsri_sweep_kernels *kernels;
} mbsri_sweeps;

/* What force elements exert on a body, about the origin of its frame; body_forces only. */
typedef struct mbsri_sweep_load {
    double r[4];   /* that origin in the world, m; the angle of a PLANAR body */
    double arm[4]; /* from there to the origin of the body's own frame */
    union {
        double L[4];     /* moment */
        double bound[4]; /* of a block: kappa, spread, `soft`, see block_bound.h; 1: bounded.h tells
                            that the block is regular in every pose */
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
    const double *tau; /* joint forces; for inverse dynamics u' */
    double *out;       /* u', joint forces, or p' */
    const double *p;   /* momenta; momentum form only */
    double *balance;   /* its algebraic equations */
    int *rank;         /* bodies + 1, or NULL */
    const double
        *eta;     /* position rows: eta, whose C^T eta is left for mbsri_sweeps_push; or NULL */
    bool springs; /* whether loop forces are those of springs alone */
    double *bias; /* rows: bias of the closures' rows, an output; or NULL */
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
