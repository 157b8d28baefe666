/* The linearised equations of the momentum form, before anything is eliminated from them: what
 * products with the Newton matrix and its elimination read.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Perturbations of a body: of its pose, e numbers (SPATIAL: a small rotation about its origin and
 * the displacement of that origin, along the world's axes; else the np numbers of the pose), of its
 * velocity V and, where it is below a massless joint, of its acceleration A, d numbers each. Below
 * a massless joint is what stands in the subtree of a joint, or group of joints, whose block D is
 * deficient. */
#ifndef MBSRI_NEWTON_LINEAR_H
#define MBSRI_NEWTON_LINEAR_H

#include "newton/slopes/force_slopes.h"
#include "sweeps/tree.h"

/* Of a body and its joint: the derivatives of mbsri_joint_slopes but for the columns of u', the
 * body's own P, and what of the data is needed. G, s and X are those of a group, at its head. What
 * concerns A and mu stands there where the body, or for columns and `below` its predecessor, is
 * below a massless joint. */
typedef struct mbsri_terms {
    double *x, *below, *own, *qdot;
    double *P;
    double *H, *Hdot, *J, *Jdot, *G, *s, *X;
} mbsri_terms;

/* Two bodies between which element `force` acts at the state: by index, and by place in its list.
 */
typedef struct mbsri_acting {
    int force, body[2], place[2];
} mbsri_acting;

typedef struct mbsri_pairs {
    int count;
    mbsri_acting *pair; /* as many as the model has at most */
} mbsri_pairs;

typedef struct mbsri_linear {
    const mbsr_model *model;
    mbsri_pairs pairs;
    double c;
    bool whole; /* keeps all for products; else P, below and own are those of the last joint, and
                 * derivatives of elements those of the last */
    const bool *served; /* N + 1: bodies that it knows; NULL: all */
    bool *below_massless,
        *coupled;    /* N + 1: of each body; coupled: one of a group that is one block */
    bool *dropped;   /* rows of closures that the data leaves out */
    int *rank, *e;   /* N + 1: of its joint, or at the head of the group; numbers of its pose */
    mbsri_terms *of; /* N + 1, as bodies are below massless joints or not */
    double *along;   /* 2 nu: derivatives of elements on one coordinate, along q, along u; */
    bool finite;     /* they are */
    size_t *motion;  /* N + 1: offset of e + 2 d numbers, in vectors of `motions` */
    size_t *terms;   /* N + 1: offsets in the store; so are the next four */
    size_t *element; /* of elements, */
    size_t *each;    /* N + 1: of those on every body, behind that */
    size_t *closure; /* S, slope and C of closures */
    size_t of_pairs, a_pair; /* of pairs, and how much each takes */
    size_t motions, bytes;
    double *store, *work; /* work: of a closure */
    double *joint, *body, *spare, *terms_of_one;
    mbsri_slopes slopes;
    struct {
        mbsri_sweep_load *load; /* N + 1 (sweeps/bounded.h); NULL: ranks by the stage alone */
        bool told;              /* whether these did, and the data is not at that stage; */
        bool free;              /* whether it is not even at that of forces: all bodies are free; */
        bool
            forward; /* which may be, as nothing transposed is solved, which reads G of such ones */
    } bounds;
} mbsri_linear;

/* Whether these derivatives can be had: MBSR_OK, or MBSR_ERR_SPACE with the body or closure and
 * what it lacks. */
int mbsri_linear_check(const mbsr_model *m, const char *function, mbsr_error *error);

/* NULL: there is no memory. */
mbsri_linear *mbsri_linear_create(const mbsr_model *m, bool whole, const bool *served);
void mbsri_linear_destroy(mbsri_linear *l);

/* The data at the state, with ranks, momenta and rates; groups of joints are taken apart where that
 * makes no difference (mbsri_backward puts them together). spare: nq + nu numbers. */
int mbsri_linear_state(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                       const double *yp, double *spare);

/* Which bodies are below a massless joint, by the data and the ranks (N + 1; NULL: those of the
 * data); whether any.
 */
bool mbsri_linear_mark(mbsri_linear *l, const mbsr_data *d, const int *rank);

/* Then all of them as below a massless joint, for derivatives of inverse dynamics. */
void mbsri_linear_mark_all(mbsri_linear *l);

/* The data at the state (t, y), with the loop forces of y', A and mu, for the factor c; bodies are
 * marked. A status. */
int mbsri_linear_open(mbsri_linear *l, mbsr_data *d, double t, const double *y, const double *yp,
                      double c);

/* Then the derivatives of joint and body i, and of element k, in the call of body or pair i. A
 * status. */
int mbsri_linear_joint(mbsri_linear *l, mbsr_data *d, int i);
int mbsri_linear_force(mbsri_linear *l, mbsr_data *d, size_t k, int i);

/* All derivatives where the data is at the state with A and mu, and bodies are marked. A status. */
int mbsri_linear_keep(mbsri_linear *l, mbsr_data *d);

/* Whether element k is gravity or acts on one coordinate alone; the derivatives of all others,
 * where the data shows their bodies at the state. */
bool mbsri_linear_is_plain(const mbsr_model *m, size_t k);
int mbsri_linear_elements(mbsri_linear *l, mbsr_data *d);

/* All derivatives at the state. A status. The data is at mbsr_stage_backward of that state
 * afterwards. */
int mbsri_linear_at(mbsri_linear *l, mbsr_data *d, double t, const double *y, const double *yp,
                    double c);

static inline mbsri_terms mbsri_linear_terms(const mbsri_linear *l, int i)
{
    return l->of[i];
}

/* Numbers of pose, V and perhaps A of a body, and of its actions: momentum, its rate and perhaps
 * the reaction. */
static inline int mbsri_linear_motions(const mbsri_linear *l, int i)
{
    return l->e[i] + (l->below_massless[i] ? 2 : 1) * l->model->body[i].d;
}

static inline int mbsri_linear_actions(const mbsri_linear *l, int i)
{
    return (l->below_massless[i] ? 3 : 2) * l->model->body[i].d;
}

/* Elements. How often one is called: for body `first` .. `last`, an element by pairs for pairs of
 * these numbers; the bodies that it sees in the call of body or pair i, and their number; its
 * derivatives there, and their rows and columns. */
void mbsri_linear_calls(const mbsri_linear *l, size_t k, int *first, int *last);
int mbsri_linear_bodies(const mbsri_linear *l, const mbsri_force *force, int i, const int **list);
const double *mbsri_linear_element(const mbsri_linear *l, size_t k, int i, int *rows, int *columns);

/* Of closure k: columns x columns, twice rows x columns. */
typedef struct mbsri_closure_part {
    const double *S, *slope, *C;
} mbsri_closure_part;

static inline mbsri_closure_part mbsri_linear_closure(const mbsri_linear *l, size_t k)
{
    const mbsri_closure *c = (const mbsri_closure *)l->model->closures.data + k;
    const size_t columns = (size_t)c->columns, rows = (size_t)c->rows;
    const double *S = l->store + l->closure[k], *slope = S + columns * columns;
    return (mbsri_closure_part){S, slope, slope + rows * columns};
}

/* y_pi += B y, the part of the predecessor's forces that does not come from the joint itself. */
void mbsri_linear_pass(const mbsri_body *b, const mbsri_terms *k, bool below_massless,
                       const double *y, double *below);

/* y += B^T below, of the same B. */
void mbsri_linear_pass_transposed(const mbsri_body *b, const mbsri_terms *k, bool below_massless,
                                  const double *below, double *y);

/* y = (1 - P) x and x = P x for momenta of a joint or group: P = S^-1 X_N X_N^T S as
 * mbsri_null_force. */
void mbsri_linear_split(const mbsri_terms *k, int n, int rank, double *x, double *y);

/* y = P^T x and x = (1 - P^T) x. */
void mbsri_linear_split_transposed(const mbsri_terms *k, int n, int rank, double *x, double *y);

/* Force element k in the order of the sweeps; closure k by id. */
static inline const mbsri_force *mbsri_force_at(const mbsr_model *m, size_t k)
{
    return (const mbsri_force *)m->forces.data + k;
}

static inline const mbsri_closure *mbsri_closure_at(const mbsr_model *m, size_t k)
{
    return (const mbsri_closure *)m->closures.data + k;
}

#endif
